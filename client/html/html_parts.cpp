#include "client/html/html_parts.hpp"

namespace dccast::client::render {
namespace {

/// Style sheet of the report: light and dark, on screen and on paper.
constexpr const char* report_style = R"css(
:root{color-scheme:light dark;--page:#f5f6f8;--card:#fff;--ink:#1c2430;--soft:#5d6878;--rule:#e1e5eb;--zero:#98a2b1;
--line-0:#1f5fbf;--line-1:#c8521a;--line-2:#2c8a57;--line-3:#8747b5;--line-4:#b5860b;--line-5:#0d8a96;--good:#1f7a46;--bad:#b3261e}
@media (prefers-color-scheme:dark){:root{--page:#12161c;--card:#1b2129;--ink:#e6eaf0;--soft:#9aa6b6;--rule:#2d3541;--zero:#66717f;
--line-0:#7fb0ff;--line-1:#ff9a63;--line-2:#6fd39b;--line-3:#c79bf0;--line-4:#e8c15a;--line-5:#5fd0da;--good:#6fd39b;--bad:#ff8a80}}
*{box-sizing:border-box}body{margin:0;background:var(--page);color:var(--ink);font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
main{max-width:1180px;margin:0 auto;padding:28px 20px 60px}header{margin-bottom:18px}.kicker{margin:0;color:var(--soft);font-size:13px}
h1{margin:4px 0 0;font-size:26px;line-height:1.25;font-weight:650}h2{margin:0 0 10px;font-size:15px;font-weight:650}
.state.succeeded{color:var(--good)}.state.failed,.state.cancelled{color:var(--bad)}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(140px,1fr));gap:12px;margin-bottom:16px}
.tile{background:var(--card);border:1px solid var(--rule);border-radius:8px;padding:12px 14px;color:var(--soft)}
.tile span{display:block;font-size:12px}.tile strong{color:var(--ink);font-size:24px;font-weight:650;font-variant-numeric:tabular-nums}
.tile small,.tile em{display:block;font-size:12px}.tile em{font-style:normal;font-size:15px;color:var(--ink);font-variant-numeric:tabular-nums}.note{color:var(--soft);font-size:13.5px;margin:0 2px 16px}
table.figures th,table.figures td{width:auto;text-align:right;padding:5px 0 5px 14px}table.figures th:first-child,table.figures td:first-child{text-align:left;padding-left:0}
table.figures .text{text-align:left}table.figures td:last-child:not(:nth-child(2)){color:inherit;font-size:inherit}table.figures td{font-variant-numeric:tabular-nums}
table.figures thead th{color:var(--soft);font-size:13px}table.figures tr.this td{font-weight:650}table.figures tr.first>*{border-top:2px solid var(--zero)}
.scroll{overflow-x:auto}.card p{margin:10px 0 0;color:var(--soft);font-size:13px}
.card{background:var(--card);border:1px solid var(--rule);border-radius:8px;padding:16px 18px;margin:0 0 16px;min-width:0;break-inside:avoid}
.pair,.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(430px,100%),1fr));gap:0 16px}.wide{grid-column:1/-1}
.views{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(300px,100%),1fr));gap:10px 16px}h3{margin:0;font-size:13px;font-weight:500;color:var(--soft)}
p.answer{font-size:18px;line-height:1.45;margin:0 0 8px;max-width:62em}p.cause{margin:0 0 16px;max-width:62em}.wanted{fill:var(--good);opacity:.12}.edge{stroke:var(--good);stroke-dasharray:6 4}
.contact{fill:#fff;stroke:#10151c;stroke-width:1.4}svg.map{max-width:680px;margin:0 auto}table.pull-in{margin-top:10px;font-size:12.5px}table.figures.pull-in th,table.figures.pull-in td{padding-left:7px}table.pull-in thead th{font-size:11.5px;vertical-align:bottom}
table.figures.pull-in tr+tr th:first-child{padding-left:7px;text-align:right}
.slider{margin:10px auto 0;max-width:900px}.slider input{width:100%;margin:0;accent-color:var(--line-0)}.slider p{margin:0;color:var(--ink);font-variant-numeric:tabular-nums}.slider small{color:var(--soft)}.beyond-now{font-weight:650;color:var(--ink)}
figure{margin:0}figcaption{color:var(--soft);font-size:13px;margin-top:8px}figcaption strong{color:var(--ink)}svg{display:block;width:100%;height:auto}
svg.section{max-width:900px;max-height:720px;margin:0 auto;overflow:visible}.grid{stroke:var(--rule)}.zero{stroke:var(--zero)}.tick{fill:var(--soft);font-size:11.5px}.label{fill:var(--ink);font-size:12px}
.beyond{fill:var(--bad);opacity:.13}p.invalid{border:1px solid var(--bad);border-radius:8px;padding:10px 14px;color:var(--bad);margin:0 0 16px}
.band{stroke:none;opacity:.18}.middle{fill:none;stroke-width:1.4;stroke-dasharray:5 4}.line{fill:none;stroke-width:2;stroke-linejoin:round}.deformed{fill:none;stroke:var(--ink);stroke-width:1.2}
.undeformed{fill:none;stroke:var(--soft);stroke-width:1;stroke-dasharray:4 4}.isotherm{fill:none;stroke:#fff;stroke-width:.9;opacity:.85}
.front{fill:none;stroke:#10151c;stroke-width:2}.front.liquidus{stroke-dasharray:6 4}
.isotherm-label{fill:#fff;font-size:11px;paint-order:stroke;stroke:#0008;stroke-width:2.5px}
table{border-collapse:collapse;width:100%;font-size:14px}th,td{text-align:left;vertical-align:top;padding:5px 10px 5px 0;border-top:1px solid var(--rule)}
tr:first-child>*{border-top:0}th{font-weight:500;width:34%}td:nth-child(2){font-variant-numeric:tabular-nums;overflow-wrap:break-word}td code{overflow-wrap:anywhere}td:last-child:not(:nth-child(2)){color:var(--soft);font-size:13px}
details{margin-top:14px}summary{cursor:pointer;color:var(--soft)}pre{overflow-x:auto;font-size:12.5px;line-height:1.45}code{font-size:12px}
tr.danger th{color:var(--bad)}.findings th{width:6em}.findings td{overflow-wrap:anywhere}.findings td:nth-child(3){white-space:nowrap}.findings td small{display:block;color:var(--soft)}
@page{size:A4;margin:9mm}
@media print{:root{color-scheme:light;--page:#fff;--card:#fff;--ink:#1c2430;--soft:#4a5463;--rule:#d5dae1;--zero:#98a2b1;
--line-0:#1f5fbf;--line-1:#c8521a;--line-2:#2c8a57;--line-3:#8747b5;--line-4:#b5860b;--line-5:#0d8a96;--good:#1f7a46;--bad:#b3261e}
*{print-color-adjust:exact;-webkit-print-color-adjust:exact}body{background:#fff;font-size:8.5px;line-height:1.3}main{max-width:none;padding:0}header{margin-bottom:4px}
h1{font-size:18px;margin:0}h2{font-size:9.5px;margin:0 0 3px}h3,.kicker,figcaption,.card p,.note,.tile span,.tile small,td:last-child:not(:nth-child(2)){font-size:7px}
.card{padding:4px 6px;margin:0 0 5px;border-radius:3px}.cards,.pair{grid-template-columns:repeat(3,1fr);gap:0 5px;grid-auto-flow:dense}svg.chart,svg.map{max-height:96px}svg.slab{max-height:140px}svg.section{max-height:230px}
.tick{font-size:13px}.label{font-size:14px}code{font-size:7px}.scroll{overflow:visible}.views{grid-template-columns:repeat(3,1fr)}
.tiles{grid-template-columns:repeat(8,1fr);gap:4px;margin-bottom:5px}.tile{padding:3px 5px;border-radius:3px}.tile strong{font-size:12px}.tile em{font-size:8.5px}
p.answer{font-size:10.5px;margin:0 0 5px;max-width:none}p.invalid{padding:3px 6px;margin:0 0 5px}figcaption{margin-top:2px}table,table.figures thead th{font-size:7.5px}
th,td{padding:1px 4px 1px 0}table.figures th,table.figures td,table.figures.pull-in th,table.figures.pull-in td{padding:1px 0 1px 2px}table.pull-in,table.pull-in thead th{font-size:6px}th{width:26%}.cards td small{font-size:6.5px}details,.slider{display:none}.sheet{break-before:page}.evidence .cards{grid-template-columns:repeat(2,1fr)}
.first{font-size:11px;line-height:1.4}.first h2{font-size:12px}.first p.answer{font-size:17px;margin:6px 0}.first p.cause{font-size:12.5px;margin:0 0 8px}
.first figcaption,.first .card p,.first h3,.first td:last-child:not(:nth-child(2)),.first td small{font-size:9px}.first table{font-size:10.5px}.first th,.first td{padding:2.5px 6px 2.5px 0}
.first .card{padding:7px 10px}.first .cards{grid-template-columns:1fr 1fr;gap:0 8px}.first svg.chart{max-height:none}.first svg.slab{max-height:220px}
.first .tiles{grid-template-columns:repeat(auto-fit,minmax(76px,1fr))}.first .tile span,.first .tile small{font-size:8.5px}.first .tile strong{font-size:15px}.first .tile em{font-size:11px}}
)css";

}  // namespace

std::string whole_page(const std::string& title, const std::string& header,
                       const std::string& body) {
  return "<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
         "content='width=device-width, initial-scale=1'>" +
         element("title", title) + element("style", report_style) + "</head><body><main>" +
         element("header", header) + body + "</main></body></html>\n";
}

std::string svg_file(const std::string& attributes, const std::string& content) {
  return "<?xml version='1.0' encoding='UTF-8'?>\n<svg xmlns='http://www.w3.org/2000/svg' " +
         attributes + ">" + element("style", report_style) + content + "</svg>\n";
}

}  // namespace dccast::client::render
