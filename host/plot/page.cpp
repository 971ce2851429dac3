// SPDX-License-Identifier: Apache-2.0
#include "host/plot/page.hpp"

#include "host/plot/svg.hpp"

namespace srd::host {
namespace {

constexpr const char* kStyle = R"css(
body { margin: 0 auto; padding: 1.5rem 1rem 3rem; max-width: 1000px; background: #fff; color: #222;
  font: 15px/1.45 "Helvetica Neue", Arial, "Liberation Sans", "DejaVu Sans", sans-serif; }
h1 { font-size: 1.5rem; margin: 0 0 .8rem; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .1rem 1.2rem; margin: 0 0 1rem; }
dt { color: #5a5a5a; } dd { margin: 0; overflow-wrap: anywhere; }
.note { border-left: 3px solid #d55e00; padding-left: .7rem; margin: .4rem 0; }
figure { margin: 2rem 0; break-inside: avoid; }
figure svg { width: 100%; height: auto; display: block; }
figure > svg text { font-family: inherit; }
figcaption { color: #444; max-width: 75ch; margin-top: .3rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 2rem 0; break-inside: avoid; }
caption { text-align: left; color: #444; padding-bottom: .4rem; }
th, td { text-align: right; padding: .2rem .9rem; } th:first-child, td:first-child { text-align: left; padding-left: 0; }
thead th { border-bottom: 1px solid #5a5a5a; font-weight: 600; } tbody td { border-bottom: 1px solid #e4e4e4; }
@media print { body { padding: 0; max-width: none; } .cursor { display: none; } }
)css";

// Values under the pointer: the nearest point of the panel's series, from the path itself.
constexpr const char* kScript = R"js(
for (const axes of document.querySelectorAll("rect.axes")) {
  const svg = axes.ownerSVGElement, box = axes.getBBox();
  const [x0, x1] = axes.dataset.x.split(" ").map(Number), [y0, y1] = axes.dataset.y.split(" ").map(Number);
  const log = axes.dataset.log === "1", name = "http://www.w3.org/2000/svg";
  let points = null, mark = null;
  const series = () => [...svg.querySelectorAll("svg")]
    .filter(s => ["x", "y"].every(a => s.getAttribute(a) === axes.getAttribute(a)))
    .flatMap(s => [...s.querySelectorAll("path.series")])
    .flatMap(p => [...p.getAttribute("d").matchAll(/[ML]([-\d.e]+) ([-\d.e]+)/g)].map(m => [+m[1], +m[2]]))
    .sort((a, b) => a[0] - b[0]);
  const nearest = x => {
    let low = 0, high = points.length - 1;
    while (high - low > 1) { const middle = (low + high) >> 1; if (points[middle][0] < x) low = middle; else high = middle; }
    return Math.abs(points[low][0] - x) <= Math.abs(points[high][0] - x) ? points[low] : points[high];
  };
  const value = (part, a, b, l) => l ? a * Math.pow(b / a, part) : a + part * (b - a);
  axes.addEventListener("pointermove", event => {
    points = points || series();
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const [x, y] = points.length ? nearest(at.x) : [at.x, at.y];
    if (!mark) {
      mark = svg.appendChild(document.createElementNS(name, "g"));
      mark.setAttribute("class", "cursor"); mark.setAttribute("pointer-events", "none");
      mark.innerHTML = '<line stroke="#222" stroke-width=".6"/><circle r="3" fill="#d55e00"/>' +
        '<text font-size="11" fill="#222" stroke="#fff" stroke-width="4" paint-order="stroke"/>';
    }
    const [line, dot, text] = mark.children;
    line.setAttribute("x1", x); line.setAttribute("x2", x);
    line.setAttribute("y1", box.y); line.setAttribute("y2", box.y + box.height);
    dot.setAttribute("cx", x); dot.setAttribute("cy", y);
    const left = x > box.x + box.width / 2;
    text.setAttribute("x", x + (left ? -6 : 6)); text.setAttribute("y", box.y + 13);
    text.setAttribute("text-anchor", left ? "end" : "start");
    text.textContent = value((x - box.x) / box.width, x0, x1, false).toPrecision(5) + " " + axes.dataset.xUnit + ", " +
      value(1 - (y - box.y) / box.height, y0, y1, log).toPrecision(4) + " " + axes.dataset.yUnit;
  });
  axes.addEventListener("pointerleave", () => { if (mark) mark.remove(); mark = null; });
}
)js";

std::string table_html(const PageTable& table) {
  std::string out = "<table><caption>" + escaped(table.caption) + "</caption>\n<thead><tr>";
  for (const std::string& cell : table.header) out += "<th scope=\"col\">" + escaped(cell) + "</th>";
  out += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    out += "<tr>";
    for (const std::string& cell : row) out += "<td>" + escaped(cell) + "</td>";
    out += "</tr>\n";
  }
  return out + "</tbody></table>\n";
}

}  // namespace

std::string page_html(const Page& page) {
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      escaped(page.title) + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<h1>" + escaped(page.title) +
      "</h1>\n<dl>\n";
  for (const auto& [name, value] : page.facts) out += "<dt>" + escaped(name) + "</dt><dd>" + escaped(value) + "</dd>\n";
  out += "</dl>\n";
  for (const std::string& note : page.notes) out += "<p class=\"note\">" + escaped(note) + "</p>\n";
  for (const PageFigure& figure : page.figures)
    out += "<figure>\n" + figure.svg + "<figcaption>" + escaped(figure.caption) + "</figcaption>\n</figure>\n";
  for (const PageTable& table : page.tables) out += table_html(table);
  return out + "<script>" + kScript + "</script>\n</body>\n</html>\n";
}

}  // namespace srd::host
