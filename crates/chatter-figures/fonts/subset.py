"""Makes the embedded faces from the Liberation Sans fonts (version 2).

    python3 subset.py FOLDER_WITH_LIBERATION_TTF

Needs fonttools. Keeps the characters that labels use, drops hinting and layout tables, and renames the family,
because the licence reserves the original name for unmodified fonts.
"""

import pathlib
import sys

from fontTools import subset
from fontTools.ttLib import TTFont

CHARACTERS = [
    (0x20, 0x7E),  # ASCII
    (0xA0, 0x17F),  # Latin-1 and Latin Extended-A: names of people
    (0x2C6, 0x2DD),  # spacing accents, drawn above mathematical letters
    (0x391, 0x3A9),
    (0x3B1, 0x3C9),  # Greek
    (0x3D1, 0x3D2),
    (0x3D5, 0x3D6),
    (0x3F5, 0x3F5),
    (0x410, 0x44F),  # Cyrillic
    (0x2010, 0x2026),  # dashes, quotation marks, dots
    (0x2032, 0x2033),
]
SINGLE = "−×·÷±≤≥≠≈∞√∂∑∫→←↔↑↓∆∏℃ℓ‖≡∩†"


def make(source: pathlib.Path, face: str, target: pathlib.Path) -> None:
    font = TTFont(source / f"LiberationSans-{face}.ttf")
    wanted = {c for low, high in CHARACTERS for c in range(low, high + 1)} | {ord(c) for c in SINGLE}
    options = subset.Options(
        hinting=False, layout_features=[], notdef_outline=True, name_IDs=[0, 1, 2, 4, 5, 6, 13, 14], glyph_names=False
    )
    options.drop_tables += ["FFTM", "GDEF", "GPOS", "GSUB", "kern", "DSIG", "meta"]
    job = subset.Subsetter(options)
    job.populate(unicodes=wanted)
    job.subset(font)
    for record in font["name"].names:
        new = {
            1: "Chatter Sans",
            2: face,
            4: f"Chatter Sans {face}",
            6: f"ChatterSans-{face}",
        }.get(record.nameID)
        if new:
            record.string = new
    font.recalcTimestamp = False
    font.save(target / f"ChatterSans-{face}.ttf")


if __name__ == "__main__":
    here = pathlib.Path(__file__).parent
    for face in ("Regular", "Italic"):
        make(pathlib.Path(sys.argv[1]), face, here)
