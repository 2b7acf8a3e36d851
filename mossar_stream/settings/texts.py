"""What users write and hand over for settings, as values of the kinds that settings have."""


def parse_group(field: str, value: str) -> object:
    """Read `positions:0.75,log_speed:0.25` and the words none/null/auto of optional fields."""
    if field in ("features", "variance_floor"):
        parts = [part.partition(":") for part in value.split(",")]
        return {name.strip(): number(text) for name, _, text in parts}
    if field == "limbs" and value.lower() in ("true", "false"):
        return value.lower() == "true"
    if value in ("none", "null", "auto") and field not in ("smoothing", "location", "up"):
        return None
    return value if field == "feet" else number(value)


def number(text: str) -> object:
    """Return the number that a text stands for, or the text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def plain(value: object) -> object:
    """Return a value, for a number of numpy's the same of Python's."""
    return value.item() if getattr(value, "ndim", None) == 0 and hasattr(value, "item") else value
