"""The certificate of a calibration as one page that a laboratory files.

From top to bottom: the sensor and what identifies the session; each triad with its verdict,
parameters, figures and residuals; the references with their traceability; how to read it.
"""

from collections.abc import Sequence

import numpy as np

from pipeline.export.certificate_content import certificate_content
from pipeline.export.certificate_records import (
    CertificateContent,
    CertifiedRow,
    Residuals,
    TriadPart,
)
from pipeline.export.parts import Export
from pipeline.export.sheet import ACCENT, HEIGHT, INK, LINE, QUIET, WIDTH, A4Sheet, own_settings
from pipeline.results.read import Stored
from pipeline.text.formatting import count

FILE_NAME = "certificate.pdf"
MARGIN, GAP = 16.0, 8.0  #: mm; layout
TOP, BOTTOM = 17.0, HEIGHT - 12.0  #: mm, of the title and of the foot; layout
LINE_HEIGHT, ROW = 4.3, 9.2  #: of a table's line, of a row of parameters
PLOT = (24.0, 72.0)  #: least and largest height of a chart
VERDICT_LINES, SIZE = 6, 6.8  #: of a verdict at most; of the text, pt
MOST_REFERENCES = 7  #: rows; the rest is counted
SIGNS = {"good": ("✓", "#1d7240", "#e9f4ed"), "act": ("!", "#a63a12", "#fbeee8"),
         "open": ("?", "#7a5b00", "#f8f3e0")}  # fmt: skip


def certificate_pdf(stored: Stored) -> Export:
    """``certificate.pdf``, one page of A4; equal results and history give equal bytes."""
    content = certificate_content(stored)
    with own_settings():
        sheet = A4Sheet()
        lost = draw_certificate(sheet, content)
        data = sheet.pdf({"Title": f"Calibration certificate: {content.sensor}",
                          "Subject": content.title, "Creator": dict(content.facts)["Program"]})
    if sheet.absent:
        lost.append(f"The font of the page lacks {len(sheet.absent)} letters of the names; a box "
                    f"stands for each.")
    return Export({FILE_NAME: data}, tuple(lost))


def draw_certificate(sheet: A4Sheet, content: CertificateContent) -> list[str]:
    """Put everything on the sheet; the sentences returned name what it has no room for."""
    top = _head(sheet, content)
    lost: list[str] = []
    foot = BOTTOM - 3 - _notes(sheet, content, None)
    references = min(len(content.references), MOST_REFERENCES + 1)
    tables = foot - 5 - LINE_HEIGHT * references
    columns = max(len(content.triads), 1)
    width = (WIDTH - 2 * MARGIN - GAP * (columns - 1)) / columns
    lines = max((_verdict_lines(sheet, part, width) for part in content.triads), default=0)
    ends = []
    for i, part in enumerate(content.triads):
        y, more = _triad(sheet, part, MARGIN + i * (width + GAP), top, width, tables - 6, lines)
        ends.append(y)
        lost += more
    for i, part in enumerate(content.triads):
        height = min(tables - 12 - max(ends), PLOT[1])
        _plot(sheet, part.residuals, MARGIN + i * (width + GAP), max(ends), width, height)
    if not content.triads:
        sheet.text(MARGIN, top + 6, "Only the rate of the plate was measured.", 9)
    lost += _references(sheet, content, tables)
    _notes(sheet, content, foot)
    sheet.rule(MARGIN, BOTTOM - 1, WIDTH - 2 * MARGIN)
    sheet.text(MARGIN, BOTTOM + 3, " · ".join(dict(content.facts)[key] for key in (
        "Program", "Date of calibration", "Configuration")), 6, colour=QUIET,
        most=WIDTH - 2 * MARGIN - 22)
    sheet.text(WIDTH - MARGIN, BOTTOM + 3, "Page 1 of 1", 6, colour=QUIET, right=True)
    return lost


def _head(sheet: A4Sheet, content: CertificateContent) -> float:
    sheet.rule(MARGIN, 10, WIDTH - 2 * MARGIN, ACCENT, 1.6)
    sheet.text(MARGIN, TOP, "C A L I B R A T I O N   C E R T I F I C A T E", 6.6, colour=ACCENT,
               bold=True)
    sheet.text(MARGIN, TOP + 9.5, content.sensor, 19, bold=True, most=104)
    sheet.text(MARGIN, TOP + 15.5, content.title, 9, colour=QUIET, most=104)
    for i, (name, value) in enumerate(content.facts):
        y = TOP + i * LINE_HEIGHT
        sheet.text(128, y, name, 6.6, colour=QUIET)
        sheet.text(156, y, value, 6.6, most=WIDTH - MARGIN - 156)
    y = TOP + 20
    sheet.rule(MARGIN, y, WIDTH - 2 * MARGIN)
    return y + 7


# --- a triad -----------------------------------------------------------------------------------


def _verdict_lines(sheet: A4Sheet, part: TriadPart, width: float) -> int:
    return min(len(sheet.wrapped(part.explanation, width - 13, SIZE)), VERDICT_LINES)


def _triad(
    sheet: A4Sheet, part: TriadPart, x: float, y: float, width: float, end: float, lines: int
) -> tuple[float, list[str]]:
    """One triad from ``y`` to at most ``end``, its verdict ``lines`` long, but for its chart.

    Where the chart may begin, and what there was no room for.
    """
    named = sheet.text(x, y, part.name, 12, bold=True)
    sheet.text(x + width, y, part.range, SIZE, colour=QUIET, right=True, most=width - named - 4)
    y += 5
    sheet.text(x, y, f"Model: {part.model}", SIZE, colour=QUIET, most=width)
    y = _verdict(sheet, part, x, y + 3, width, lines)
    below = 20.0 + _height_of_blind(sheet, part, width) + PLOT[0] + 6
    fits = int((end - y - 4 - LINE_HEIGHT - below) / ROW)
    rows = part.rows if len(part.rows) <= fits else part.rows[: max(fits, 3)]
    y = _parameters(sheet, rows, x, y + 4, width)
    lost = []
    if len(rows) < len(part.rows):
        more = len(part.rows) - len(rows)
        sheet.text(x, y + 1, f"and {count(more, 'row')} more in results.json", SIZE, colour=QUIET)
        y += LINE_HEIGHT
        lost.append(f"The page has no room for {count(more, 'row')} of the parameters of the "
                    f"{part.name.lower()}: results.json holds them.")
    y = _figures(sheet, part, x, y + 4, width)
    y = sheet.paragraph(x, y + 1.5, part.prediction, width, SIZE, most=2)
    y = sheet.paragraph(x, y + 1, _blind_text(part), width, SIZE, colour=QUIET, most=3)
    return y + 2, lost


def _blind_text(part: TriadPart) -> str:
    return f"Not determined by these data: {part.not_determined}."


def _height_of_blind(sheet: A4Sheet, part: TriadPart, width: float) -> float:
    return 3.5 * min(len(sheet.wrapped(_blind_text(part), width, SIZE)), 3)


def _verdict(
    sheet: A4Sheet, part: TriadPart, x: float, y: float, width: float, lines: int
) -> float:
    sign, colour, soft = SIGNS[part.standing]
    height = 7.6 + 3.42 * lines
    sheet.box(x, y, width, height, soft)
    sheet.box(x, y, 1.2, height, colour)
    sheet.text(x + 4, y + 5.2, sign, 10, colour=colour, bold=True)
    sheet.text(x + 9.5, y + 5, part.verdict, 7.8, bold=True, colour=colour, most=width - 12)
    sheet.paragraph(x + 9.5, y + 8.7, part.explanation, width - 13, SIZE, most=VERDICT_LINES)
    return y + height + 2


def _parameters(
    sheet: A4Sheet, rows: Sequence[CertifiedRow], x: float, y: float, width: float
) -> float:
    third = width / 3
    for k, axis in enumerate("xyz"):
        sheet.text(x + k * third, y, axis, 6.6, colour=ACCENT, bold=True)
    sheet.rule(x, y + 1.2, width, INK, 0.7)
    for row in rows:
        sheet.text(x, y + 4.3, row.name, 6.2, colour=QUIET, most=width)
        for k, each in enumerate(row.values):
            room = third - 3
            whole = sheet.width(f"{each.value} {each.sd}", 7.8)
            size = 7.8 * min(1.0, room / max(whole, 1e-9))
            wide = sheet.text(x + k * third, y + 8.3, each.value, size)
            sheet.text(x + k * third + wide + 1, y + 8.3, each.sd, size * 0.9, colour=QUIET)
        sheet.rule(x, y + ROW + 0.8, width)
        y += ROW
    return y + 3


def _figures(sheet: A4Sheet, part: TriadPart, x: float, y: float, width: float) -> float:
    """The figures side by side, each as wide as it needs to be."""
    needs = [max(sheet.width(name, 5.8), sheet.width(value, 7.2, bold=True)) + 1.0
             for name, value in part.figures]
    shrink = min(1.0, (width - 2.0 * (len(needs) - 1)) / sum(needs))
    gap = (width - shrink * sum(needs)) / max(len(needs) - 1, 1)
    for (name, value), need in zip(part.figures, needs, strict=True):
        sheet.text(x, y, name, 5.8 * shrink, colour=QUIET)
        sheet.text(x, y + 3.9, value, 7.2 * shrink, bold=True)
        x += shrink * need + gap
    return y + 8


def _plot(
    sheet: A4Sheet, residuals: Residuals, x: float, y: float, width: float, height: float
) -> None:
    """Residuals in the order of the poses over their noise, the runs side by side."""
    sheet.text(x, y + 1.4, f"Residuals [{residuals.unit}] over ± 1 sd of the noise of each pose",
               6.2, colour=QUIET, most=width)
    axes = sheet.axes(x + 8, y + 4, width - 8, height - 8)
    n = np.arange(len(residuals.value))
    low = np.where(residuals.is_length, 0.0, -residuals.sd)
    axes.bar(n, residuals.sd - low, 0.9, low, color="#c9dcf2")
    axes.axhline(0, color=QUIET, linewidth=0.6)
    size = float(np.clip(180 / len(n), 1.4, 3.4))
    for mask, marker in ((~residuals.is_length, "o"), (residuals.is_length, "D")):
        axes.plot(n[mask], residuals.value[mask], marker, color=ACCENT, markersize=size,
                  markeredgewidth=0)
    runs = residuals.run
    starts = [i for i in range(len(runs)) if i == 0 or runs[i] != runs[i - 1]]
    for start, end in zip(starts, [*starts[1:], len(runs)], strict=True):
        if start:
            axes.axvline(start - 0.5, color=LINE, linewidth=0.6)
        sheet.text(x + 8 + (start + 0.3) / len(runs) * (width - 8), y + height - 1,
                   runs[start], 5.4, colour=QUIET,
                   most=max((end - start) / len(runs) * (width - 8) - 1, 1.0))
    reach = 1.1 * float(np.max(np.abs(residuals.value) + residuals.sd))
    axes.set(xlim=(-0.5, len(n) - 0.5), ylim=(0 if residuals.is_length.all() else -reach, reach),
             xticks=[])
    axes.locator_params(axis="y", nbins=5)
    axes.tick_params(labelsize=5.4, length=2, width=0.5, pad=1.5)
    for side in ("top", "right", "bottom"):
        axes.spines[side].set_visible(False)


# --- the foot ----------------------------------------------------------------------------------


def _references(sheet: A4Sheet, content: CertificateContent, y: float) -> list[str]:
    sheet.text(MARGIN, y, "Reference and traceability", 8, bold=True)
    shown = content.references
    if len(shown) > MOST_REFERENCES + 1:
        shown = shown[:MOST_REFERENCES]
    for name, value, source in shown:
        y += LINE_HEIGHT
        sheet.text(MARGIN, y, name, 6.6, colour=QUIET, most=32)
        sheet.text(MARGIN + 34, y, value, 6.6, most=58)
        sheet.text(MARGIN + 94, y, source, 6.6, most=WIDTH - 2 * MARGIN - 94)
    more = len(content.references) - len(shown)
    if not more:
        return []
    sheet.text(MARGIN, y + LINE_HEIGHT, f"and {more} more in results.json", 6.6, colour=QUIET)
    return [f"The page has no room for {more} of the references: results.json holds them."]


def _notes(sheet: A4Sheet, content: CertificateContent, y: float | None) -> float:
    """The notes from ``y`` on, if any; the height that they take."""
    width, size = WIDTH - 2 * MARGIN, 6.0
    height = 0.0
    for note in content.notes:
        lines = min(len(sheet.wrapped(note, width, size)), 4)
        if y is not None:
            sheet.paragraph(MARGIN, y + height, note, width, size, colour=QUIET, most=4)
        height += 1.42 * size * 25.4 / 72 * lines + 0.8
    return height
