// SPDX-License-Identifier: Apache-2.0
#include "host/plot/svg.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <span>

#include "drivers/support/text_file.hpp"
#include "host/plot/png.hpp"

namespace srd::host {
namespace {

// Hundredths of a unit: finer than any printer.
std::string coordinate(double x) {
  const double rounded = std::round(x * 100) / 100;
  return number_text(rounded == 0 ? 0 : rounded);
}

std::string attribute(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + escaped(value) + "\"";
}

std::string paint(const char* name, const std::optional<Colour>& colour) {
  if (!colour) return attribute(name, "none");
  std::array<char, 8> hex{};
  std::snprintf(hex.data(), hex.size(), "#%02x%02x%02x", colour->red, colour->green, colour->blue);
  std::string out = attribute(name, hex.data());
  if (colour->opacity < 1) out += attribute((std::string(name) + "-opacity").c_str(), number_text(colour->opacity));
  return out;
}

std::string box(const Rectangle& r) {
  return attribute("x", coordinate(r.x)) + attribute("y", coordinate(r.y)) + attribute("width", coordinate(r.width)) +
         attribute("height", coordinate(r.height));
}

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const unsigned three =
        unsigned{bytes[i]} << 16U | (left > 1 ? unsigned{bytes[i + 1]} << 8U : 0U) | (left > 2 ? unsigned{bytes[i + 2]} : 0U);
    out += kDigits[three >> 18U & 63U];
    out += kDigits[three >> 12U & 63U];
    out += left > 1 ? kDigits[three >> 6U & 63U] : '=';
    out += left > 2 ? kDigits[three & 63U] : '=';
  }
  return out;
}

struct Writer {
  std::string out;
  std::optional<Problem> problem;

  void operator()(const Lines& lines) {
    std::string path;
    for (const auto& part : lines.parts) {
      for (std::size_t i = 0; i < part.size(); ++i)
        path += (i == 0 ? "M" : "L") + coordinate(part[i].x) + " " + coordinate(part[i].y);
      if (part.size() == 1) path += "h0";  // with round caps: a dot
    }
    std::string element = "<path" + attribute("d", path) + paint("fill", lines.fill);
    if (!lines.role.empty()) element += attribute("class", lines.role);
    if (lines.stroke)
      element += paint("stroke", lines.stroke->colour) + attribute("stroke-width", coordinate(lines.stroke->width)) +
                 attribute("stroke-linejoin", "round") + attribute("stroke-linecap", "round");
    element += "/>";
    // A nested svg clips without an id, so figures can stand together in one page.
    if (lines.clip) {
      const Rectangle& r = *lines.clip;
      element = "<svg" + box(r) +
                attribute("viewBox",
                          coordinate(r.x) + " " + coordinate(r.y) + " " + coordinate(r.width) + " " + coordinate(r.height)) +
                ">" + element + "</svg>";
    }
    out += element + "\n";
  }
  void operator()(const Text& text) {
    const std::string at = coordinate(text.at.x) + " " + coordinate(text.at.y);
    out += "<text" + attribute("x", coordinate(text.at.x)) + attribute("y", coordinate(text.at.y)) +
           attribute("font-size", coordinate(text.size)) + paint("fill", text.colour);
    if (text.anchor != Anchor::kStart) out += attribute("text-anchor", text.anchor == Anchor::kMiddle ? "middle" : "end");
    if (text.bold) out += attribute("font-weight", "bold");
    if (text.upwards) out += attribute("transform", "rotate(-90 " + at + ")");
    out += ">" + escaped(text.text) + "</text>\n";
  }
  void operator()(const Image& image) {
    const auto png = png_bytes(image);
    if (!png) {
      problem = png.error();
      return;
    }
    out += "<image" + box(image.over) + attribute("preserveAspectRatio", "none") +
           attribute("href", "data:image/png;base64," + base64(*png)) + "/>\n";
  }
  void operator()(const AxesMark& axes) {
    out += "<rect class=\"axes\" fill=\"none\" pointer-events=\"all\"" + box(axes.area) +
           attribute("data-x", number_text(axes.x_low) + " " + number_text(axes.x_high)) +
           attribute("data-y", number_text(axes.y_low) + " " + number_text(axes.y_high)) +
           attribute("data-log", axes.y_logarithmic ? "1" : "0") + attribute("data-x-unit", axes.x_unit) +
           attribute("data-y-unit", axes.y_unit) + "/>\n";
  }
};

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default: out += c;
    }
  return out;
}

Outcome<std::string> svg_element(const Scene& scene, const std::string& label) {
  Writer writer;
  writer.out = "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\"" + attribute("aria-label", label) +
               attribute("viewBox", "0 0 " + coordinate(scene.width()) + " " + coordinate(scene.height())) + ">\n";
  for (const Shape& shape : scene.shapes()) std::visit(writer, shape);
  if (writer.problem) return *writer.problem;
  return writer.out + "</svg>\n";
}

}  // namespace srd::host
