"""Find the installed browser and open pages in it with the network cut."""

import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, BrowserContext, Error, sync_playwright

from pgm_book.make.errors import PublishError

_COMMANDS = (
    "chromium",
    "google-chrome",
    "google-chrome-stable",
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


def named_browser() -> str | None:
    """Return the browser that the variable ``PGM_BROWSER`` names, if it names one."""
    named = os.environ.get("PGM_BROWSER")
    if not named:
        return None
    found = shutil.which(named)
    if not found:
        raise PublishError(f"PGM_BROWSER names {named!r}, which is not a program.")
    return found


def find_browser(downloaded: str = "") -> str:
    """Return the path of an installed Chromium, Chrome or Edge.

    `downloaded` is where ``playwright install chromium`` puts one.
    """
    # Last, because on Ubuntu this may be a stub that only asks for a snap.
    candidates = (*_COMMANDS, *_installed(), downloaded, "chromium-browser")
    for candidate in filter(None, candidates):
        found = shutil.which(candidate)
        if found:
            return found
    raise PublishError(
        "No browser found. Install Chromium, Chrome or Edge, or name one by its path "
        "in the environment variable PGM_BROWSER. Without the right to install, this "
        f"fetches one: {sys.executable} -m playwright install chromium"
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
    named = named_browser()
    with sync_playwright() as playwright:
        path = named or find_browser(playwright.chromium.executable_path)
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
