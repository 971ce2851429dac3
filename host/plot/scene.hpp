// SPDX-License-Identifier: Apache-2.0
// A drawing as a list of shapes, drawn once and written as SVG (for the page) or PNG (for print).
// Units: 1/96 inch as in SVG, x right, y down. Text is UTF-8.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace srd::host {

struct Place {
  double x = 0, y = 0;
};

struct Rectangle {
  double x = 0, y = 0, width = 0, height = 0;
  [[nodiscard]] double right() const { return x + width; }
  [[nodiscard]] double bottom() const { return y + height; }
};

struct Colour {
  std::uint8_t red = 0, green = 0, blue = 0;
  double opacity = 1;
};

struct Stroke {
  Colour colour;
  double width = 1;
};

// Open lines, or filled closed ones; parts of one shape are not joined. A part of one point is a dot.
struct Lines {
  std::vector<std::vector<Place>> parts;
  std::optional<Stroke> stroke{};
  std::optional<Colour> fill{};
  std::optional<Rectangle> clip{};
  std::string role{};  // SVG class, for the page's script
};

enum class Anchor : std::uint8_t { kStart, kMiddle, kEnd };

struct Text {
  Place at;  // on the base line
  std::string text;
  double size = 11;
  Anchor anchor = Anchor::kStart;
  Colour colour{};
  bool bold = false;
  bool upwards = false;  // turned to read from bottom to top
};

// Pixels stretched over a rectangle, smoothly.
struct Image {
  Rectangle over;
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // 3 width height bytes, rows from the top
};

// Where a panel's axes are, so that the page's script can turn pixels into values.
struct AxesMark {
  Rectangle area;
  double x_low = 0, x_high = 1, y_low = 0, y_high = 1;
  bool y_logarithmic = false;
  std::string x_unit, y_unit;
};

using Shape = std::variant<Lines, Text, Image, AxesMark>;

class Scene {
 public:
  Scene(double width, double height) : width_(width), height_(height) {}
  [[nodiscard]] double width() const { return width_; }
  [[nodiscard]] double height() const { return height_; }
  [[nodiscard]] const std::vector<Shape>& shapes() const { return shapes_; }

  void add(Lines lines);
  void add(Text text);
  void add(Image image);
  void add(AxesMark axes);
  void line(Place from, Place to, const Stroke& stroke) { add(Lines{.parts = {{from, to}}, .stroke = stroke}); }
  void box(const Rectangle& r, std::optional<Colour> fill, std::optional<Stroke> stroke = std::nullopt);

 private:
  double width_, height_;
  std::vector<Shape> shapes_;
};

// About how wide a text is in a sans-serif font; for legends and to keep labels apart.
[[nodiscard]] double text_width(const std::string& text, double size);

}  // namespace srd::host
