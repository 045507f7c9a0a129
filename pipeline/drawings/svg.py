"""What the drawings of the bench are put together from, as text of an SVG."""

from html import escape


def picture_head(width: float, height: float, title: str) -> list[str]:
    """The start of a white picture of ``width`` by ``height`` px, with tips for arrows."""
    tips = "".join(
        f'<marker id="{name}" markerWidth="8" markerHeight="8" refX="6" refY="4" orient="auto">'
        f'<path d="M0 0L8 4L0 8z" fill="{colour}"/></marker>'
        for name, colour in (("tip", "#333"), ("pale-tip", "white")))
    return [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
        f'width="{width:g}" height="{height:g}" font-family="sans-serif" font-size="13">',
        f"<title>{escape(title)}</title>", f"<defs>{tips}</defs>",
        '<rect width="100%" height="100%" fill="white"/>',
    ]


def filled_box(x: float, y: float, width: float, height: float, colour: str) -> str:
    """A filled rectangle with its upper left corner at ``x``, ``y``."""
    return (f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" '
            f'fill="{colour}" stroke="#333"/>')


def words_at(x: float, y: float, words: str, colour: str = "#333") -> str:
    """Words that begin at ``x``, ``y``."""
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}">{escape(words)}</text>'
