"""Text for people: nearest name, one line."""

from difflib import get_close_matches


def nearest(name: str, names: list[str]) -> str:
    """Hint at the nearest of some names, or all of them where none is near."""
    near = get_close_matches(name, names, n=1)
    if near:
        return f"; did you mean '{near[0]}'?"
    return f"; known: {', '.join(names[:12])}" if names else ""
