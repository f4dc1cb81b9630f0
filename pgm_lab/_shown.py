"""What a cell shows, also where there is no notebook."""

from typing import Any


def publish_display_data(
    data: dict[str, Any], metadata: dict[str, Any] | None = None
) -> None:
    """Show in the IPython that runs; elsewhere print the words, and start none.

    IPython's own function would start a shell, which keeps a thread and a file open.
    """
    from IPython import display, get_ipython

    if get_ipython() is None:
        print(data["text/plain"])
    else:
        display.publish_display_data(data, metadata)
