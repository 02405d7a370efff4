"""How the demo's page looks."""

from __future__ import annotations

from ..bench.chart_style import BLUE, FAINT, GREEN, INK, RULE, VERMILION

STYLE = f"""
:root {{ color-scheme: light; --ink: {INK}; --faint: {FAINT}; --rule: {RULE}; --good: #00795a;
  --bad: #b84a00; --accent: {BLUE}; --card: #fff; --ground: #f5f6f8; }}
* {{ box-sizing: border-box; }}
body {{ margin: 0; background: var(--ground); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial,
  "DejaVu Sans", sans-serif; font-variant-numeric: tabular-nums; }}
main {{ max-width: 1120px; margin: 0 auto; padding: 36px 24px 64px; }}
h1 {{ font-size: 27px; line-height: 1.2; margin: 0 0 4px; letter-spacing: -0.01em; }}
h2 {{ font-size: 19px; margin: 0; }}
h3 {{ font-size: 12px; margin: 20px 0 6px; color: var(--faint); font-weight: 600;
  text-transform: uppercase; letter-spacing: 0.05em; }}
p {{ margin: 0; }}
.faint {{ color: var(--faint); }}
.legend {{ color: var(--faint); font-size: 13px; margin-top: 12px; }}
.legend b {{ color: var(--ink); font-weight: 600; }}
.term, [title] {{ text-decoration: underline dotted #9aa3ad; text-underline-offset: 3px;
  cursor: help; }}
.tiles {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(130px, 1fr)); gap: 12px;
  margin: 24px 0; }}
.tile, .card {{ background: var(--card); border: 1px solid var(--rule); border-radius: 10px; }}
.tile {{ padding: 14px 16px 12px; }}
.tile b {{ display: block; font-size: 25px; line-height: 1.15; font-weight: 650; }}
.tile span {{ color: var(--faint); font-size: 13px; }}
.card {{ padding: 20px 22px; margin: 20px 0; overflow: hidden; }}
.wide {{ overflow-x: auto; }}
video {{ display: block; width: 100%; background: #000; border-radius: 6px; }}
table {{ border-collapse: collapse; width: 100%; font-size: 14px; }}
th {{ text-align: left; color: var(--faint); font-weight: 600; font-size: 12.5px;
  border-bottom: 1px solid #cfd4da; padding: 6px 14px 6px 0; white-space: nowrap; }}
td {{ border-bottom: 1px solid var(--rule); padding: 7px 14px 7px 0; vertical-align: top; }}
tr:last-child td {{ border-bottom: 0; }}
td.n, th.n {{ text-align: right; }}
.swatch {{ display: inline-block; width: 11px; height: 11px; border-radius: 3px;
  margin-right: 7px; }}
.pill {{ display: inline-block; padding: 1px 10px; border-radius: 99px; font-size: 13px;
  font-weight: 600; background: {GREEN}22; color: var(--good); white-space: nowrap; }}
.pill.bad {{ background: {VERMILION}22; color: var(--bad); }}
.head {{ display: flex; align-items: baseline; gap: 12px; flex-wrap: wrap; margin-bottom: 14px; }}
.pictures {{ display: grid; grid-template-columns: 1fr 1fr; gap: 12px; }}
figure {{ margin: 0; }}
figure img {{ display: block; width: 100%; border-radius: 6px; background: #111; }}
figcaption {{ color: var(--faint); font-size: 13px; margin-top: 5px; }}
.key {{ display: inline-block; width: 18px; height: 4px; border-radius: 2px; vertical-align: 3px;
  margin: 0 4px 0 8px; outline: 1px solid #0005; }}
.timeline {{ display: block; width: 100%; height: auto; margin-top: 4px; }}
.two {{ display: grid; grid-template-columns: 3fr 2fr; gap: 28px; }}
dl {{ display: grid; grid-template-columns: max-content 1fr; gap: 4px 14px; margin: 0;
  font-size: 14px; }}
dt {{ color: var(--faint); }}
dd {{ margin: 0; }}
.numbers {{ display: flex; flex-wrap: wrap; gap: 4px 26px; margin-top: 12px; font-size: 14px; }}
.numbers b {{ font-weight: 650; }}
@media (max-width: 760px) {{ .pictures, .two {{ grid-template-columns: 1fr; }} }}
@media print {{ body {{ background: #fff; }} .card {{ break-inside: avoid; }} }}
"""
"""The page's style sheet; system fonts, as nothing may be loaded from a network."""
