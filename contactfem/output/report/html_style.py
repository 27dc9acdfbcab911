"""Style sheet of the HTML page."""

STYLE = """
:root { color-scheme: light dark; --ink: #1c2128; --soft: #5c6670; --line: #dfe3e8; --back: #ffffff;
  --card: #f6f8fa; --accent: #2166ac; --good: #1b7837; --bad: #b2182b; --good-back: #e6f4ea;
  --bad-back: #fbe9ea; }
@media (prefers-color-scheme: dark) { :root { --ink: #e3e7ec; --soft: #9aa5b1; --line: #333b45;
  --back: #14181d; --card: #1c2229; --accent: #7db4ea; --good: #7fd090; --bad: #f28b93;
  --good-back: #16301f; --bad-back: #3a1a1e; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 68rem; padding: 1.5rem 1.25rem 4rem; background: var(--back);
  color: var(--ink); font: 16px/1.55 system-ui, sans-serif; }
h1 { font-size: 1.65rem; line-height: 1.25; margin: .2rem 0 .6rem; text-wrap: balance; }
h2 { font-size: 1.15rem; margin: 2.6rem 0 .7rem; padding-bottom: .3rem;
  border-bottom: 1px solid var(--line); }
p { margin: .5rem 0; }
a { color: var(--accent); }
.soft { color: var(--soft); }
.verdict { display: inline-block; padding: .1rem .7rem; border-radius: 1rem; font-weight: 600;
  font-size: .9rem; }
.good { color: var(--good); } .bad { color: var(--bad); }
.verdict.good { background: var(--good-back); } .verdict.bad { background: var(--bad-back); }
.stop { background: var(--bad-back); border-left: 4px solid var(--bad); padding: .7rem 1rem;
  border-radius: .25rem; margin: 1rem 0; overflow-wrap: anywhere; }
.stop.doubt { background: var(--card); border-color: #d08700; }
.facts { display: grid; grid-template-columns: repeat(auto-fit, minmax(8.5rem, 1fr)); gap: .6rem;
  margin: 1.1rem 0 0; }
.facts div { background: var(--card); border: 1px solid var(--line); border-radius: .5rem;
  padding: .55rem .8rem; }
.facts dt { color: var(--soft); font-size: .8rem; }
.facts dd { margin: 0; font-size: 1.2rem; font-weight: 600; font-variant-numeric: tabular-nums; }
pre { background: var(--card); border: 1px solid var(--line); border-radius: .5rem;
  padding: .7rem 1rem; overflow-x: auto; font: .85rem/1.5 ui-monospace, monospace; }
.scroll { overflow: auto; max-height: 36rem; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th { position: sticky; top: 0; background: var(--back); color: var(--soft); font-weight: 600;
  vertical-align: bottom; }
th, td { text-align: right; padding: .28rem .8rem; border-bottom: 1px solid var(--line);
  white-space: nowrap; }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
.words td:last-child { text-align: left; white-space: normal; overflow-wrap: anywhere; }
.words td:first-child { color: var(--soft); vertical-align: top; }
.cost td:last-child { text-align: left; }
.bar { display: inline-block; height: .6rem; background: var(--accent); border-radius: 2px;
  opacity: .75; }
.curve { display: block; } .curve polyline { fill: none; stroke: var(--accent); stroke-width: 1.3; }
.curve circle { fill: var(--accent); } .curve .level { stroke: var(--soft); stroke-width: .7;
  stroke-dasharray: 3 2; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr));
  gap: 1rem; align-items: start; }
figure { margin: 0; background: #ffffff; border: 1px solid var(--line); border-radius: .5rem;
  padding: .6rem; }
figure img { display: block; max-width: 100%; height: auto; margin: 0 auto; }
figcaption { color: #5c6670; font-size: .8rem; text-align: center; padding-top: .3rem; }
details { margin: .6rem 0; } summary { cursor: pointer; color: var(--accent); }
ul { padding-left: 1.2rem; } li { margin: .25rem 0; overflow-wrap: anywhere; }
footer { margin-top: 3rem; color: var(--soft); font-size: .85rem; }
@media (max-width: 40rem) { body { padding: 1rem .9rem 3rem; } h1 { font-size: 1.35rem; }
  th, td { padding: .25rem .55rem; } }
@media print { .scroll { max-height: none; } details { display: none; } }
"""
