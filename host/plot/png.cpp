// SPDX-License-Identifier: Apache-2.0
#include "host/plot/png.hpp"

#include <cairo.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <span>

namespace srd::host {
namespace {

struct Release {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* context) const { cairo_destroy(context); }
};
using Surface = std::unique_ptr<cairo_surface_t, Release>;
using Context = std::unique_ptr<cairo_t, Release>;

void set_colour(cairo_t* c, const Colour& colour) {
  cairo_set_source_rgba(c, colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0, colour.opacity);
}

Surface surface_of(const Image& image) {
  Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height));
  unsigned char* pixels = cairo_image_surface_get_data(surface.get());
  if (pixels == nullptr) return surface;
  cairo_surface_flush(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::size_t at =
          3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
      const std::uint32_t pixel = static_cast<std::uint32_t>(image.rgb[at]) << 16U |
                                  static_cast<std::uint32_t>(image.rgb[at + 1]) << 8U | image.rgb[at + 2];
      std::memcpy(pixels + y * stride + 4 * x, &pixel, sizeof pixel);
    }
  cairo_surface_mark_dirty(surface.get());
  return surface;
}

struct Painter {
  cairo_t* c;

  void operator()(const Lines& lines) const {
    cairo_save(c);
    if (lines.clip) {
      cairo_rectangle(c, lines.clip->x, lines.clip->y, lines.clip->width, lines.clip->height);
      cairo_clip(c);
    }
    cairo_new_path(c);
    for (const auto& part : lines.parts) {
      if (part.empty()) continue;
      cairo_move_to(c, part[0].x, part[0].y);
      for (const Place& p : part) cairo_line_to(c, p.x, p.y);
    }
    if (lines.fill) {
      set_colour(c, *lines.fill);
      cairo_fill_preserve(c);
    }
    if (lines.stroke) {
      set_colour(c, lines.stroke->colour);
      cairo_set_line_width(c, lines.stroke->width);
      cairo_set_line_cap(c, CAIRO_LINE_CAP_ROUND);
      cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
      cairo_stroke_preserve(c);
    }
    cairo_new_path(c);
    cairo_restore(c);
  }
  void operator()(const Text& text) const {
    cairo_save(c);
    cairo_select_font_face(c, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           text.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    // DejaVu is wider than the fonts that browsers take: a little smaller, it needs the same room.
    cairo_set_font_size(c, 0.93 * text.size);
    cairo_text_extents_t extents;
    cairo_text_extents(c, text.text.c_str(), &extents);
    const double back = text.anchor == Anchor::kStart    ? 0
                        : text.anchor == Anchor::kMiddle ? 0.5 * extents.x_advance
                                                         : extents.x_advance;
    cairo_translate(c, text.at.x, text.at.y);
    if (text.upwards) cairo_rotate(c, -0.5 * M_PI);
    cairo_move_to(c, -back, 0);
    set_colour(c, text.colour);
    cairo_show_text(c, text.text.c_str());
    cairo_restore(c);
  }
  void operator()(const Image& image) const {
    const Surface surface = surface_of(image);
    cairo_save(c);
    cairo_rectangle(c, image.over.x, image.over.y, image.over.width, image.over.height);
    cairo_clip(c);
    cairo_translate(c, image.over.x, image.over.y);
    cairo_scale(c, image.over.width / image.width, image.over.height / image.height);
    cairo_set_source_surface(c, surface.get(), 0, 0);
    cairo_pattern_set_extend(cairo_get_source(c), CAIRO_EXTEND_PAD);  // else the border fades out
    cairo_paint(c);
    cairo_restore(c);
  }
  void operator()(const AxesMark&) const {}
};

cairo_status_t append(void* closure, const unsigned char* bytes, unsigned length) {
  auto& out = *static_cast<std::vector<std::uint8_t>*>(closure);
  const std::span<const unsigned char> more(bytes, length);
  out.insert(out.end(), more.begin(), more.end());
  return CAIRO_STATUS_SUCCESS;
}

Problem cannot(const std::string& where, cairo_status_t status) {
  return Problem{Exit::kInput,
                 "the image cannot be written",
                 where,
                 "a folder that can be written, with room",
                 cairo_status_to_string(status),
                 ""};
}

}  // namespace

Outcome<void> write_png(const Scene& scene, const std::filesystem::path& file) {
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24,
                                                   static_cast<int>(std::lround(scene.width() * kPngPixelsPerUnit)),
                                                   static_cast<int>(std::lround(scene.height() * kPngPixelsPerUnit))));
  const Context context(cairo_create(surface.get()));
  set_colour(context.get(), {255, 255, 255});
  cairo_paint(context.get());
  cairo_scale(context.get(), kPngPixelsPerUnit, kPngPixelsPerUnit);
  for (const Shape& shape : scene.shapes()) std::visit(Painter{context.get()}, shape);
  cairo_status_t status = cairo_status(context.get());
  if (status == CAIRO_STATUS_SUCCESS) status = cairo_surface_write_to_png(surface.get(), file.c_str());
  if (status != CAIRO_STATUS_SUCCESS) return cannot(file.string(), status);
  return {};
}

Outcome<std::vector<std::uint8_t>> png_bytes(const Image& image) {
  std::vector<std::uint8_t> bytes;
  const Surface surface = surface_of(image);
  const cairo_status_t status = cairo_surface_write_to_png_stream(surface.get(), &append, &bytes);
  if (status != CAIRO_STATUS_SUCCESS) return cannot("memory", status);
  return bytes;
}

}  // namespace srd::host
