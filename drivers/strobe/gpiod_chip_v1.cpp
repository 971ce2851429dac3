// SPDX-License-Identifier: Apache-2.0
#include <gpiod.h>

#include "drivers/strobe/gpiod_chip.hpp"

namespace srd {

namespace {

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
using Chip = std::shared_ptr<gpiod_chip>;

// Keeps its chip open: in this version a line belongs to it.
class Line final : public OutputLine {
 public:
  Line(Chip chip, gpiod_line* line) : chip_(std::move(chip)), line_(line) {}
  ~Line() override {
    set(false);
    gpiod_line_release(line_);
  }
  void set(bool on) noexcept override {
    if (gpiod_line_set_value(line_, on ? 1 : 0) != 0) ++faults_;
  }
  [[nodiscard]] std::uint64_t faults() const noexcept override { return faults_; }

 private:
  Chip chip_;
  gpiod_line* line_;
  std::uint64_t faults_ = 0;
};

class ChipV1 final : public GpioChip {
 public:
  explicit ChipV1(Chip chip) : chip_(std::move(chip)) {}
  [[nodiscard]] std::string name() const override { return gpiod_chip_name(chip_.get()); }
  [[nodiscard]] std::string label() const override { return gpiod_chip_label(chip_.get()); }
  [[nodiscard]] unsigned line_count() const override { return gpiod_chip_num_lines(chip_.get()); }

  [[nodiscard]] bool line(unsigned offset, GpioLineInfo& info) const override {
    gpiod_line* line = gpiod_chip_get_line(chip_.get(), offset);
    if (line == nullptr) return false;
    const char* name = gpiod_line_name(line);
    const char* consumer = gpiod_line_consumer(line);
    info = {offset, name == nullptr ? "" : name, gpiod_line_is_used(line), consumer == nullptr ? "" : consumer};
    return true;
  }

  [[nodiscard]] std::unique_ptr<OutputLine> request(unsigned offset, bool active_low,
                                                    const std::string& consumer) const override {
    gpiod_line* line = gpiod_chip_get_line(chip_.get(), offset);
    if (line == nullptr) return nullptr;
    const gpiod_line_request_config config{consumer.c_str(), GPIOD_LINE_REQUEST_DIRECTION_OUTPUT,
                                           active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0};
    if (gpiod_line_request(line, &config, 0) != 0) return nullptr;
    return std::make_unique<Line>(chip_, line);
  }

 private:
  Chip chip_;
};

}  // namespace

std::unique_ptr<GpioChip> GpioChip::open(const std::string& path) {
  gpiod_chip* chip = gpiod_chip_open(path.c_str());
  if (chip == nullptr) return nullptr;
  return std::make_unique<ChipV1>(Chip(chip, CloseChip()));
}

std::string GpioChip::library_version() { return gpiod_version_string(); }

}  // namespace srd
