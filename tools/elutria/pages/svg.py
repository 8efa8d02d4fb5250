"""Figures as SVG within a page, with a title on each mark that a browser shows under the mouse."""

from __future__ import annotations

import io
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence

import matplotlib as mpl
from matplotlib.figure import Figure

from elutria.output.style import STYLE

SVG, XLINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"


def inline_svg(
    figure: Figure, label: str, titles: Mapping[str, Sequence[str]] | None = None
) -> str:
    """The figure as an <svg> element, called `label` by readers that do not see it.

    `titles` gives, for the group of a name (an artist's gid), the words of each mark in it.
    """
    buffer = io.StringIO()
    with mpl.rc_context(STYLE):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    ElementTree.register_namespace("", SVG)
    ElementTree.register_namespace("xlink", XLINK)
    root = ElementTree.fromstring(buffer.getvalue())
    for child in root.findall(f"{{{SVG}}}metadata"):
        root.remove(child)
    for group in root.iter(f"{{{SVG}}}g"):
        words = (titles or {}).get(group.get("id", ""), ())
        for mark, text in zip(group.iter(f"{{{SVG}}}use"), words, strict=False):
            ElementTree.SubElement(mark, f"{{{SVG}}}title").text = text
    for name in ("width", "height"):  # the page sets them
        root.attrib.pop(name, None)
    root.set("role", "img")
    root.set("aria-label", label)
    text = ElementTree.tostring(root, encoding="unicode")
    return re.sub(r"\n\s*", "\n", text)
