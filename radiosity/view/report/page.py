"""A report as one HTML file: nothing is loaded from elsewhere, nothing needs a script."""

from base64 import b64encode
from importlib.resources import files

from radiosity.scene.markup import Markup, cell, line, swatch, table
from radiosity.view.image import Image, png
from radiosity.view.report.figures import Figures
from radiosity.view.report.numbers import measured, plain
from radiosity.view.report.words import TERMS, error_words, percent
from radiosity.view.report.zones import Zone

MOST_ROWS = 40  # of a table
REFUSE = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"  # lets nothing else in


def page(figures: Figures, pictures: list[Image], maps: list[tuple[Zone, bytes]]) -> str:
    """Return the HTML of a report.

    Parameters
    ----------
    figures : Figures
    pictures : list of Image
        Those that ``figures`` tell of.
    maps : list of (Zone, bytes)
        Each with its map as a PNG file.
    """
    parts = [
        _title(figures), _summary(figures), _pictures(figures, pictures), _zones(figures),
        _maps(maps), _lights(figures), _materials(figures), _model(figures), _power(figures),
        _error(figures), _findings(figures), _settings(figures), _terms(),
    ]  # fmt: skip
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{cell(REFUSE)}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{cell(figures.scene)} - lighting report</title>\n"
        f"<style>\n{_style(figures)}</style>\n</head>\n<body>\n" + "\n".join(filter(None, parts))
        + "\n</body>\n</html>\n"
    )  # fmt: skip


def _style(figures) -> str:
    """Return the style sheet with the words at the edges of printed pages."""
    text = (files(__package__) / "style.css").read_text(encoding="utf-8")
    made = f"radiosity {figures.versions['radiosity']}"
    for mark, words in {
        "__TITLE__": figures.scene, "__DATE__": figures.date, "__MADE__": made,
    }.items():  # fmt: skip
        text = text.replace(mark, _css(words))
    return text


def _css(words) -> str:
    """Return text for a string of a style sheet, in which no sign means anything."""
    return "".join(c if c.isascii() and c.isalnum() else f"\\{ord(c):x} " for c in words)


def _title(figures) -> str:
    where = f"{figures.file}, " if figures.file else ""
    made = f"radiosity {figures.versions['radiosity']}"
    return (
        '<header class="title"><p class="kind">Lighting report</p>'
        f"<h1>{cell(figures.scene)}</h1><p>{cell(f'{where}{figures.date}, {made}')}</p></header>"
    )


def _summary(figures) -> str:
    """Return what one looks for first."""
    rows = [(z.name, _map_words(z).removeprefix(f"{z.name}: ")) for z in figures.grids]
    flux = figures.power.lumens["emitted"]
    inside = "closed" if figures.closed else "open: light leaves it"
    rows += [
        ("estimated error", "; ".join([percent(figures.error.reached), _asked(figures)])),
        ("light", f"{plain(flux)} lm from {_sources(figures)}"),
        ("scene", f"{figures.contents}; {inside}"),
    ]  # fmt: skip
    return f'<section class="keys">{table([], rows)}</section>'


def _asked(figures) -> str:
    error = figures.error
    if error.asked is None:
        return "the best within a given time"
    return f"{percent(error.asked)} asked for" if error.aimed else "on the mesh given"


def _sources(figures) -> str:
    """Return how many lights there are, and materials that shine."""
    some = {"light": len(figures.lights), "shining material": len(_shining(figures))}
    told = [f"{n} {word}{'' if n == 1 else 's'}" for word, n in some.items() if n]
    return " and ".join(told) or "nothing"


def _shining(figures):
    return [m for m in figures.materials if m.flux_lm > 0]


def _pictures(figures, pictures) -> str:
    if not pictures:
        said = "There is no picture: the scene has no camera, or none was asked for."
        return _section("Pictures", line(said))
    shown = "\n".join(
        _figure(_inline(png(image.shown())), f"Camera {told.camera}", _caption(told))
        for image, told in zip(pictures, figures.pictures, strict=True)
    )
    return _section("Pictures", Markup(f'<div class="pictures">{shown}</div>'))


def _caption(told) -> str:
    noise = told.noise
    left = "" if noise is None else f", noise {percent(noise)} of the mean luminance (rms)"
    return f"Camera {told.camera}: gathered, exposure {told.exposure:.3g}{left}"


def _zones(figures) -> str:
    heads = ["", "mean", "smallest", "largest", "U0 = min/mean", "Ud = min/max", "points"]
    parts = []
    level = all(z.kind == "plane" for z in figures.grids)
    named = "Planes" if level else "Grids asked for"
    for title, zones in ((named, figures.grids), ("Surfaces", figures.surfaces)):
        if zones:
            rows, more = _capped([_zone_row(z) for z in zones])
            parts += [Markup(f"<h3>{title}, illuminance in lx</h3>"),
                      table(heads, rows, range(1, 7)), more]  # fmt: skip
    grids = [z for z in (*figures.grids, *figures.surfaces) if z.spacing]
    if grids:
        parts.append(_note(
            "Points lie in the middles of cells as EN 12464-1 wants them, unless a spacing was "
            f"given. {' '.join(f'{_cell(z, figures.unit)}.' for z in figures.grids)} Surfaces have "
            "no margin. U0 and Ud are of the points."
        ))  # fmt: skip
    if any(z.where is None for z in figures.surfaces):
        parts.append(_note("(p): surfaces of many faces are told by the means of their patches."))
    parts += [_note(words) for words in figures.remarks]
    return _section("Illuminance", *parts)


def _zone_row(zone):
    many = f"{zone.points}" + (" (p)" if zone.where is None else "")
    if zone.left_out:
        many += f" of {zone.points + zone.left_out}"
    values = [_lux(zone, k) for k in ("mean", "minimum", "maximum")]
    return [zone.name, *values, _ratio(zone, "u0"), _ratio(zone, "ud"), many]


def _cell(zone, unit) -> str:
    size = " x ".join(f"{s:.3g}" for s in zone.spacing)
    return f"{zone.name}: cells of {size} {unit}, {zone.margin:.3g} {unit} from walls"


def _lux(zone, name) -> str:
    return measured(getattr(zone.found, name), getattr(zone.found, f"{name}_error"))


def _ratio(zone, name) -> str:
    return measured(getattr(zone.found, name), getattr(zone.found, f"{name}_error"))


def _maps(maps) -> str:
    if not maps:
        return ""
    shown = [
        _figure(_inline(stored), f"Map of {zone.name}", _map_words(zone)) for zone, stored in maps
    ]
    note = _note(
        "White lines join places of equal illuminance, in lx as at the line and at the scale. "
        "Black lines are walls or edges, dots the points of the table."
    )
    body = Markup(f'<div class="maps">{"".join(shown)}</div>')
    return _section("Maps of illuminance", note, body)


def _map_words(zone) -> str:
    words = f"{zone.name}: mean {_lux(zone, 'mean')} lx, U0 = {_ratio(zone, 'u0')}"
    if zone.left_out:
        every = zone.points + zone.left_out
        words += f", of {zone.points} of {every} points, the others lie in bodies or near them"
    return words


def _lights(figures) -> str:
    parts = []
    rows = [
        [k, light.kind, light.place_words if light.place else "outside", plain(light.flux_lm),
         plain(light.peak_cd), light.group, light.label or light.strength]
        for k, light in enumerate(figures.lights, 1)
    ]  # fmt: skip
    if rows:
        rows, more = _capped(rows)
        where = f"position ({figures.unit}) or direction"
        heads = ["", "type", where, "flux lm", "peak cd", "light group", "read as, or strength"]
        parts += [table(heads, rows, [0, 3, 4]), more]
    shining = _shining(figures)
    if shining:
        rows, more = _capped([
            [m.name, plain(m.area_m2), plain(m.luminance_cd_m2), plain(m.flux_lm)] for m in shining
        ])  # fmt: skip
        parts += [Markup("<h3>Surfaces that shine</h3>"),
                  table(["material", "area m²", "luminance cd/m²", "flux lm"], rows, [1, 2, 3]),
                  more]  # fmt: skip
    if not parts:
        parts.append(line("Nothing in the scene shines."))
    groups, more = _capped(list(figures.light_groups))
    said = f"Light groups: {', '.join(groups) or 'none'}."
    return _section("Lights", *parts, _note(f"Fluxes are those computed with. {said}"), more)


def _materials(figures) -> str:
    rows, more = _capped([
        [Markup(f"{swatch(m.rgb)} {cell(m.name)}"), plain(m.area_m2), m.faces,
         f"{m.reflectance:.3g}", m.diffuse, m.more.strip().replace("  ", "; ") or "matt"]
        for m in sorted(figures.materials, key=lambda m: -m.area_m2)
    ])  # fmt: skip
    heads = ["material", "area m²", "faces", "reflectance", "in bands", "beside"]
    return _section("Materials", table(heads, rows, [1, 2, 3]), more)


def _model(figures) -> str:
    rows = [[r.name, r.model, r.reason] for r in figures.requirements]
    return _section(
        "What was modelled",
        table(["part", "modelled", "because"], rows),
        Markup("<h3>What is not modelled</h3>"),
        _listed(figures.left_out),
    )


def _power(figures) -> str:
    power, names = figures.power, ("emitted", "absorbed", "escaped")
    heads = ["", *(f"{b}, W" for b in power.bands), "luminous, lm"]
    rows = [
        [name, *map(plain, power.watts[name]), plain(power.lumens[name])] for name in names
    ]
    note = f"Balanced within {percent(power.defect)} of the power emitted."
    return _section("Power balance", table(heads, rows, range(1, len(heads))), line(note))


def _error(figures) -> str:
    said = error_words(figures.error)
    return _section("Accuracy", *map(line, said), _note(TERMS["± (error bar)"].join(
        ["Every number after a ± is ", "."])))  # fmt: skip


def _findings(figures) -> str:
    notes, more = _capped([*figures.findings, *(f"note: {n}" for n in figures.notes)])
    return _section("Mesh and notes", _listed(notes), more)


def _settings(figures) -> str:
    versions = ", ".join(f"{name} {number}" for name, number in figures.versions.items())
    rows = table([], [*figures.settings.items(), ("versions", versions)])
    return _section("Settings and versions", Markup(f'<div class="keys">{rows}</div>'))


def _terms() -> str:
    return _section("Terms", Markup(f'<div class="keys">{table([], TERMS.items())}</div>'))


def _section(title, *parts) -> str:
    body = "\n".join(cell(p) for p in parts if p)
    return f"<section>\n<h2>{cell(title)}</h2>\n{body}\n</section>"


def _note(words) -> Markup:
    return Markup(f'<p class="note">{cell(words)}</p>')


def _listed(words) -> Markup:
    return Markup("<ul>" + "".join(f"<li>{cell(w)}</li>" for w in words) + "</ul>")


def _capped(rows) -> tuple[list, Markup]:
    """Return as many rows as a table may have, and what is said of the others."""
    more = len(rows) - MOST_ROWS
    if more <= 0:
        return rows, Markup("")
    return rows[:MOST_ROWS], _note(f"And {more} more, which --json tells.")


def _figure(source, words, caption) -> Markup:
    return Markup(
        f'<figure><img src="{source}" alt="{cell(words)}"><figcaption>{cell(caption)}</figcaption>'
        "</figure>"
    )


def _inline(data: bytes) -> str:
    return f"data:image/png;base64,{b64encode(data).decode()}"
