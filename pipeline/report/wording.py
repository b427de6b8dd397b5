"""Numbers and sentences as the report writes them."""

import re


def signed(value: float, spec: str) -> str:
    """Format a number with a true minus sign, and without one for zero."""
    return format(value, f"z{spec}").replace("-", "−")


def true_minus(text: str) -> str:
    """Replace the hyphens of a text that is a number, or numbers, by minus signs."""
    return text.replace("-", "−")


def per_cent(part: float, decimals: int, sign: str = "") -> str:
    """Format a fraction as 12.3 %."""
    return f"{100.0 * part:{sign}.{decimals}f} %".replace("-", "−")


def sentence(text: str) -> str:
    """Capitalise the first word, unless it is a name such as c3 or route.kappa_max, and end with a full stop."""
    if not text:
        return ""
    first = text[:1].upper() if text.split()[0].isalpha() else text[:1]
    return f"{first}{text[1:].rstrip('.')}."


def greek(text: str) -> str:
    """Write kappa as a letter, but not in the names of keys, such as kappa_max."""
    return re.sub(r"\bkappa\b", "κ", text)
