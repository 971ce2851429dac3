// SPDX-License-Identifier: Apache-2.0
#include "host/plot/scene.hpp"

namespace srd::host {

void Scene::add(Lines lines) { shapes_.emplace_back(std::move(lines)); }
void Scene::add(Text text) { shapes_.emplace_back(std::move(text)); }
void Scene::add(Image image) { shapes_.emplace_back(std::move(image)); }
void Scene::add(AxesMark axes) { shapes_.emplace_back(std::move(axes)); }

void Scene::box(const Rectangle& r, std::optional<Colour> fill, std::optional<Stroke> stroke) {
  add(Lines{.parts = {{{r.x, r.y}, {r.right(), r.y}, {r.right(), r.bottom()}, {r.x, r.bottom()}, {r.x, r.y}}},
            .stroke = stroke,
            .fill = fill});
}

double text_width(const std::string& text, double size) {
  double widths = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0U) == 0x80U) continue;  // the rest of one UTF-8 character
    widths += std::string(" .,:;|'!il()").find(c) != std::string::npos ? 0.36 : 0.62;
  }
  return widths * size;
}

}  // namespace srd::host
