"""Asking: how the parts of the page that are our own HTML ask for something.

viser passes on what is done to its widgets only. A press on the chart fetches a path from the same server instead;
`server` answers it.
"""

HEADER = "X-Mossar"  # pages of other sites cannot send it without asking first, which is refused


def asking(path: str, value: str) -> str:
    """Return JavaScript that asks for something.

    Args:
        path: What for.
        value: JavaScript of what stands behind the question mark.
    """
    return f"fetch('{path}?'+({value}),{{headers:{{'{HEADER}':'1'}}}})"
