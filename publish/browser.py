"""Find the installed browser and open pages in it with the network cut."""

import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, BrowserContext, Error, sync_playwright

from publish.errors import PublishError

_COMMANDS = (
    "chromium",
    "google-chrome",
    "google-chrome-stable",
    "chromium-browser",
    "microsoft-edge",
    "chrome",
    "msedge",
)
_MACOS = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
)
_WINDOWS = (
    "Google/Chrome/Application/chrome.exe",
    "Chromium/Application/chrome.exe",
    "Microsoft/Edge/Application/msedge.exe",
)
_ARGUMENTS = [
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


def find_browser() -> str:
    """Return the path of a Chromium, Chrome or Edge.

    The environment variable ``PGM_BROWSER`` names one explicitly.
    """
    named = os.environ.get("PGM_BROWSER")
    if named:
        found = shutil.which(named)
        if found:
            return found
        raise PublishError(f"PGM_BROWSER names {named!r}, which is not a program.")
    for candidate in (*_COMMANDS, *_installed()):
        found = shutil.which(candidate)
        if found:
            return found
    raise PublishError(
        "No browser found. Install Chromium, Chrome or Edge, or name one by its path "
        "in the environment variable PGM_BROWSER."
    )


def _installed() -> list[str]:
    """List where macOS and Windows keep browsers that are not on the path."""
    if sys.platform == "darwin":
        return list(_MACOS)
    folders = ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA")
    roots = [os.environ[name] for name in folders if name in os.environ]
    return [str(Path(root, path)) for root in roots for path in _WINDOWS]


@contextmanager
def open_browser() -> Iterator[Browser]:
    """Start the browser without a window, and close it at the end."""
    arguments = list(_ARGUMENTS)
    if sys.platform == "linux" and os.geteuid() == 0:
        arguments.append("--no-sandbox")  # Chromium refuses to start as root
    path = find_browser()
    with sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=path, args=arguments)
        except Error as error:
            raise PublishError(f"{path} does not start: {error.message}") from error
        yield browser
        browser.close()


def offline_context(browser: Browser, **options) -> BrowserContext:
    """Return a browser context that reaches nothing but the page itself."""
    context = browser.new_context(**options)
    context.set_offline(True)
    context.route("**/*", _only_local)
    return context


def _only_local(route) -> None:
    if route.request.url.startswith(("file:", "data:", "about:", "blob:")):
        route.continue_()
    else:
        route.abort()
