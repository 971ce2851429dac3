// SPDX-License-Identifier: Apache-2.0
// One HTML page with everything in it: figures as inline SVG, tables, a small script that reads values under
// the pointer. Nothing is fetched; without the script all is still there.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace srd::host {

struct PageFigure {
  std::string svg;      // an element, as it stands in the page
  std::string caption;  // plain text
};

struct PageTable {
  std::string caption;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  // the first cell of each is its name
};

struct Page {
  std::string title;
  std::vector<std::pair<std::string, std::string>> facts;  // name, value
  std::vector<std::string> notes;
  std::vector<PageFigure> figures;
  std::vector<PageTable> tables;
};

[[nodiscard]] std::string page_html(const Page& page);

}  // namespace srd::host
