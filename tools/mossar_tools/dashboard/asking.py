"""Asking: how the parts of the page that are our own HTML ask for something.

viser passes on events of its widgets only. A press on the chart fetches a path from the same server instead;
`server` answers it.
"""

HEADER = "X-Mossar"  # pages of other sites cannot send it without asking first, which is refused


def asking(path: str, value: str) -> str:
    """Return JavaScript of a request.

    Args:
        path: Path of the request.
        value: JavaScript of the text behind the question mark.
    """
    return f"fetch('{path}?'+({value}),{{headers:{{'{HEADER}':'1'}}}})"
