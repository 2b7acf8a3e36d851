"""Style: how the page's own parts look, in light and dark, from the palette shared with pictures."""

import msgspec

from mossar_tools.palette import DARK, LIGHT, Palette

PANEL = 330  # px, width of the controls
STRIP = 224  # px, height of the chart
SCROLL_BAR = 11  # px, width of the controls' scroll bar, which lies over their content
OVERVIEW = 58  # px, height of the whole take below it
PHONE = 576  # px, narrower windows have the controls in a sheet at the bottom (viser's breakpoint)
SHEET = 0.38  # of the height of a phone, for the controls

_RULES = """
.mossar { color: var(--ink); font: 12px/1.35 -apple-system, BlinkMacSystemFont, "Segoe UI", Roboto, "Helvetica Neue",
  Arial, sans-serif; font-variant-numeric: tabular-nums; letter-spacing: 0; }
.mossar b { font-weight: 650; }
.mossar .dim { color: var(--muted); }
.m-strip { position: fixed; left: 0; bottom: 0; right: %(panel)dpx; height: %(strip)dpx; z-index: 4;
  background: var(--background); border-top: 1px solid var(--faint); box-sizing: border-box; padding: 8px 18px 6px; }
.m-strip.above { bottom: %(overview)dpx; border-bottom: 0; }
.m-whole { position: fixed; left: 0; bottom: 0; right: %(panel)dpx; height: %(overview)dpx; z-index: 4;
  background: var(--background); box-sizing: border-box; padding: 4px 18px 0; overflow: hidden; }
.m-place { background: none; pointer-events: none; z-index: 5; }
.m-whole svg { display: block; overflow: visible; }
.m-whole text { font-size: 10px; fill: var(--muted); }
.m-whole .whole { fill: var(--muted); opacity: .5; } .m-whole .stem { stroke: var(--c); stroke-width: 1; }
.m-whole rect.moving { fill: var(--moving); } .m-whole rect.resting { fill: var(--resting); }
.m-whole .window { fill: var(--ink); fill-opacity: .1; stroke: var(--ink); stroke-opacity: .45; }
.m-whole .head { stroke: var(--level); stroke-width: 2; }
.mossar .ground, .mossar .touch { fill: transparent; }
.mossar [onpointerdown] { cursor: pointer; touch-action: none; }
.m-top { display: flex; justify-content: space-between; gap: 18px; height: 20px; white-space: nowrap;
  overflow: hidden; }
.m-legend { display: flex; gap: 14px; color: var(--muted); }
.m-legend span { display: inline-flex; align-items: center; gap: 5px; }
.m-strip svg { display: block; overflow: visible; }
.m-strip svg.plot { width: 100%%; }
.m-strip svg.box { overflow: hidden; }
.m-strip text { font-size: 11px; fill: var(--muted); }
.m-strip text.name { fill: var(--ink); font-weight: 600; }
.m-strip text.in { fill: var(--on); font-size: 11px; font-weight: 600; }
.mossar path, .mossar line { vector-effect: non-scaling-stroke; fill: none; }
.m-strip .band { fill: var(--faint); opacity: .62; }
.m-strip .curve { stroke: var(--ink); stroke-width: 1.7; stroke-linejoin: round; }
.m-strip .area { fill: var(--moving); opacity: .20; }
.m-strip .theta { stroke: var(--muted); stroke-dasharray: 5 4; }
.m-strip .axis { stroke: var(--faint); }
.m-strip .stem { stroke-width: 1.4; opacity: .8; }
.m-strip .head { stroke: var(--level); stroke-width: 2; }
.mossar .onset { --c: var(--onset); } .mossar .offset { --c: var(--offset); } .mossar .minimum { --c: var(--minimum); }
.mossar .mark { stroke: var(--c); stroke-width: 1.6; fill: var(--background); }
.mossar .mark.final { fill: var(--c); }
.mossar .mark.merged { opacity: .55; stroke-width: 1.1; }
.mossar .mark.tentative { stroke-dasharray: 2 2; }
.m-strip .stem { stroke: var(--c); }
.m-strip rect.moving { fill: var(--moving); } .m-strip rect.resting { fill: var(--resting); }
.m-strip text.limb { fill: var(--ink); font-size: 8px; }
.m-strip rect.move { fill: var(--level); opacity: .25; } .m-strip text.move { fill: var(--ink); font-size: 11px; font-weight: 600; }
.m-pill { display: inline-block; border-radius: 9px; padding: 1px 9px; font-weight: 600; color: var(--on); }
.m-pill.moving { background: var(--moving); } .m-pill.resting { background: var(--resting); }
.m-card { padding: 2px 10px 6px; }
.m-card.state { display: flex; justify-content: space-between; align-items: baseline; padding: 8px 10px 4px; }
.m-card .big { font-size: 22px; font-weight: 650; line-height: 1.1; }
.m-card .count { font-size: 44px; font-weight: 650; line-height: 1; }
.m-card table { width: 100%%; border-collapse: collapse; }
.m-card td { padding: 1.5px 0; white-space: nowrap; } .m-card td:not(:first-child) { text-align: right; }
.m-card th { text-align: right; font-weight: 500; color: var(--muted); padding: 0 0 2px; }
.m-card th:first-child { text-align: left; }
.m-card i { font-style: normal; } .m-card tr.merged { opacity: .5; }
.m-card .onset { color: var(--onset); } .m-card .offset { color: var(--offset); }
.m-card .minimum { color: var(--minimum); }
.m-note { min-height: 17px; color: var(--muted); white-space: normal; overflow-wrap: anywhere; }
.m-red { display: inline-block; width: 8px; height: 8px; border-radius: 50%%; background: var(--level); }
.m-count { position: fixed; left: 0; right: %(panel)dpx; top: 4vh; z-index: 6; pointer-events: none; text-align: center; }
.m-count b { display: block; font-size: min(26vh, 190px); line-height: 1; font-weight: 700; color: var(--level); }
.m-count.watch b, .m-count.taken b { color: var(--moving); } .m-count.failed b { color: var(--muted); }
.m-count span { display: inline-block; font-size: 22px; padding: 2px 12px; border-radius: 6px; background: var(--background); }
.m-rings { position: fixed; left: 18px; bottom: calc(%(strip)dpx + 14px); z-index: 5; pointer-events: none; display: flex; flex-wrap: wrap; gap: 22px; }
.m-ring { display: flex; align-items: center; gap: 14px; font-size: 17px; }
.m-ring b { display: inline-block; font-size: 22px; }
.m-ring svg { width: min(24vh, 170px); height: min(24vh, 170px); }
.m-ring circle { fill: none; stroke-width: 11; } .m-ring circle.ground { stroke: var(--faint); fill: var(--background); fill-opacity: .7; }
.m-ring circle.share { stroke: var(--minimum); transform: rotate(-90deg); transform-origin: 60px 60px; stroke-linecap: butt; }
.m-ring text { font-size: 50px; font-weight: 700; text-anchor: middle; dominant-baseline: central; fill: var(--ink); }
.m-ring span { background: var(--background); border-radius: 6px; padding: 2px 10px; opacity: .92; }
.m-move { margin-top: 6px; overflow-wrap: anywhere; } .m-examples { display: flex; flex-wrap: wrap; gap: 6px; }
.m-example { position: relative; margin: 0; border: 1px solid var(--faint); border-radius: 5px; }
.m-example svg { display: block; } .m-example path { stroke: var(--ink); stroke-width: 1.6; stroke-linecap: round; }
.m-example circle { fill: var(--ink); } .m-example .faint { opacity: .22; }
.m-example figcaption { position: absolute; left: 4px; bottom: 0; font-size: 9px; color: var(--muted); }
.m-example button { position: absolute; right: 0; top: 0; border: 0; background: none; color: var(--muted); cursor: pointer;
  font-size: 16px; line-height: 1; padding: 3px 5px; }
.m-example button:hover { color: var(--level); }
.mantine-ScrollArea-viewport:has(.m-level) { padding-right: %(bar)dpx; }
@media (max-width: 1180px) { .m-legend span:nth-child(n+4), .m-strip .more { display: none; } }
@media (max-width: 905px) { .m-legend, .m-strip text.wide { display: none; } }
@media (max-width: %(phone)fpx) {
  .m-strip, .m-strip.above { top: 0; bottom: auto; right: 0; border: 0; padding: 6px 10px 0; }
  .m-strip:not(.above) { border-bottom: 1px solid var(--faint); }
  .m-whole { top: %(strip)dpx; bottom: auto; right: 0; padding: 4px 10px 0; border-bottom: 1px solid var(--faint); }
  .m-rings { left: 10px; bottom: auto; top: calc(%(strip)dpx + 8px); } .m-ring { font-size: 14px; } .m-ring svg { width: 84px; height: 84px; }
  .m-count { right: 0; top: %(strip)dpx; } .m-count b { font-size: 15vh; } .m-count span { font-size: 16px; }
  .mantine-Paper-root:has(.m-strip) { width: 100%% !important; max-height: %(sheet)d%% !important; }
  .mantine-Paper-root:has(.m-strip) [style*="20em"] { width: 100vw !important; }
}
"""


def sheet() -> str:
    """Return the style sheet as an HTML element."""
    light, dark = _variables(LIGHT, "#1f2430"), _variables(DARK, "#14171f")
    sizes = {"panel": PANEL, "strip": STRIP, "overview": OVERVIEW, "sheet": 100 * SHEET, "bar": SCROLL_BAR}
    rules = _RULES % {**sizes, "phone": PHONE - 0.02}
    return (
        f"<style>.mossar {{ {light} }}\n[data-mantine-color-scheme=dark] .mossar {{ {dark} --resting: #6f93b0; }}"
        f"\n{rules}</style>"
    )


def rgb(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue of `#rrggbb`."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def _variables(palette: Palette, on: str) -> str:
    """Return CSS variables of a palette.

    Args:
        palette: Colours.
        on: Colour of words on coloured ground.
    """
    colours = msgspec.structs.asdict(palette)
    return " ".join(f"--{name}: {value};" for name, value in colours.items()) + f" --on: {on};"
