// SPDX-License-Identifier: Apache-2.0
#include <gpiod.h>

#include "drivers/strobe/gpiod_chip.hpp"

namespace srd {

namespace {

template <auto free>
struct Free {
  template <class T>
  void operator()(T* object) const {
    free(object);
  }
};
using Chip = std::unique_ptr<gpiod_chip, Free<gpiod_chip_close>>;
using ChipInfo = std::unique_ptr<gpiod_chip_info, Free<gpiod_chip_info_free>>;
using LineInfo = std::unique_ptr<gpiod_line_info, Free<gpiod_line_info_free>>;
using Settings = std::unique_ptr<gpiod_line_settings, Free<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Free<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Free<gpiod_request_config_free>>;
using Request = std::unique_ptr<gpiod_line_request, Free<gpiod_line_request_release>>;

class Line final : public OutputLine {
 public:
  Line(Request request, unsigned offset) : request_(std::move(request)), offset_(offset) {}
  ~Line() override { set(false); }
  void set(bool on) noexcept override {
    if (gpiod_line_request_set_value(request_.get(), offset_, on ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE) != 0)
      ++faults_;
  }
  [[nodiscard]] std::uint64_t faults() const noexcept override { return faults_; }

 private:
  Request request_;
  unsigned offset_;
  std::uint64_t faults_ = 0;
};

class ChipV2 final : public GpioChip {
 public:
  ChipV2(Chip chip, ChipInfo info) : chip_(std::move(chip)), info_(std::move(info)) {}
  [[nodiscard]] std::string name() const override { return gpiod_chip_info_get_name(info_.get()); }
  [[nodiscard]] std::string label() const override { return gpiod_chip_info_get_label(info_.get()); }
  [[nodiscard]] unsigned line_count() const override {
    return static_cast<unsigned>(gpiod_chip_info_get_num_lines(info_.get()));
  }

  [[nodiscard]] bool line(unsigned offset, GpioLineInfo& info) const override {
    const LineInfo line(gpiod_chip_get_line_info(chip_.get(), offset));
    if (!line) return false;
    const char* name = gpiod_line_info_get_name(line.get());
    const char* consumer = gpiod_line_info_get_consumer(line.get());
    info = {offset, name == nullptr ? "" : name, gpiod_line_info_is_used(line.get()), consumer == nullptr ? "" : consumer};
    return true;
  }

  [[nodiscard]] std::unique_ptr<OutputLine> request(unsigned offset, bool active_low,
                                                    const std::string& consumer) const override {
    const Settings settings(gpiod_line_settings_new());
    const LineConfig lines(gpiod_line_config_new());
    const RequestConfig owner(gpiod_request_config_new());
    if (!settings || !lines || !owner) return nullptr;
    gpiod_line_settings_set_active_low(settings.get(), active_low);
    gpiod_request_config_set_consumer(owner.get(), consumer.c_str());
    if (gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_OUTPUT) != 0 ||
        gpiod_line_settings_set_output_value(settings.get(), GPIOD_LINE_VALUE_INACTIVE) != 0 ||
        gpiod_line_config_add_line_settings(lines.get(), &offset, 1, settings.get()) != 0)
      return nullptr;
    Request request(gpiod_chip_request_lines(chip_.get(), owner.get(), lines.get()));
    if (!request) return nullptr;
    return std::make_unique<Line>(std::move(request), offset);
  }

 private:
  Chip chip_;
  ChipInfo info_;
};

}  // namespace

std::unique_ptr<GpioChip> GpioChip::open(const std::string& path) {
  Chip chip(gpiod_chip_open(path.c_str()));
  if (!chip) return nullptr;
  ChipInfo info(gpiod_chip_get_info(chip.get()));
  if (!info) return nullptr;
  return std::make_unique<ChipV2>(std::move(chip), std::move(info));
}

std::string GpioChip::library_version() { return gpiod_api_version(); }

}  // namespace srd
