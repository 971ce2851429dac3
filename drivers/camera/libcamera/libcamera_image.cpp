// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/libcamera/libcamera_image.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

// Controls are floats, of which a person wants to see no more than was meant.
std::string rounded(float value) { return number_text(std::round(1000.0 * static_cast<double>(value)) / 1000); }

constexpr std::int32_t kOff = 0;  // NoiseReductionModeOff, HdrModeOff and AfModeManual alike

class NamedControls {
 public:
  NamedControls(const libcamera::ControlInfoMap& known, libcamera::ControlList& set) : known_(known), set_(set) {}

  // The value that was set, inside what the camera takes; nothing: it has no such control of this type.
  std::optional<float> real(std::string_view name, float wanted) {
    const auto found = find(name, libcamera::ControlTypeFloat);
    if (found == known_.end()) return std::nullopt;
    const libcamera::ControlInfo& info = found->second;
    if (!info.min().isNone() && !info.max().isNone() && info.min().get<float>() < info.max().get<float>())
      wanted = std::clamp(wanted, info.min().get<float>(), info.max().get<float>());
    set_.set(found->first->id(), libcamera::ControlValue(wanted));
    return wanted;
  }
  // False: there is such a control, and it cannot be this. True also when there is none.
  bool choose(std::string_view name, std::int32_t value) {
    const auto found = find(name, libcamera::ControlTypeInteger32);
    if (found == known_.end()) return true;
    const std::vector<libcamera::ControlValue>& values = found->second.values();
    if (!values.empty() && std::none_of(values.begin(), values.end(), [&](const libcamera::ControlValue& offered) {
          return offered.type() == libcamera::ControlTypeInteger32 && offered.get<std::int32_t>() == value;
        }))
      return false;
    set_.set(found->first->id(), libcamera::ControlValue(value));
    return true;
  }
  [[nodiscard]] bool has(std::string_view name, libcamera::ControlType type) const { return find(name, type) != known_.end(); }

 private:
  [[nodiscard]] libcamera::ControlInfoMap::const_iterator find(std::string_view name, libcamera::ControlType type) const {
    return std::find_if(known_.begin(), known_.end(),
                        [&](const auto& entry) { return entry.first->name() == name && entry.first->type() == type; });
  }
  const libcamera::ControlInfoMap& known_;
  libcamera::ControlList& set_;
};

}  // namespace

std::vector<std::string> neutral_image(const libcamera::ControlInfoMap& known, const LibcameraOptions& options,
                                       libcamera::ControlList& set, std::vector<std::string>& notes) {
  std::vector<std::string> concerns;
  NamedControls controls(known, set);
  const float sharpness = static_cast<float>(options.sharpness.value_or(0));
  const auto sharpened = controls.real("Sharpness", sharpness);
  if (sharpened && *sharpened > 0)
    concerns.push_back("sharpness is " + rounded(*sharpened) + ", 0 is none: the camera sharpens edges");
  if (!sharpened && sharpness > 0) notes.push_back("sharpness cannot be set: the camera has no such control");
  if (!controls.choose("NoiseReductionMode", kOff)) concerns.push_back("noise reduction cannot be switched off");
  const auto neutral = [&](std::string_view name, const char* word, float wanted) {
    const auto value = controls.real(name, wanted);
    if (value && (*value < wanted || *value > wanted))
      concerns.push_back(std::string(word) + " is " + rounded(*value) + ", " + rounded(wanted) +
                         " is neutral: the camera bends grey levels");
  };
  neutral("Contrast", "contrast", 1);
  neutral("Brightness", "brightness", 0);
  neutral("Gamma", "gamma", 1);
  if (!controls.choose("HdrMode", kOff)) concerns.push_back("high dynamic range cannot be switched off");
  if (!controls.choose("AfMode", kOff)) concerns.push_back("automatic focus cannot be switched off");
  const bool lens = controls.has("LensPosition", libcamera::ControlTypeFloat);
  if (options.focus && lens) {
    const auto wanted = static_cast<float>(*options.focus);
    if (const auto position = controls.real("LensPosition", wanted); position && (*position < wanted || *position > wanted))
      notes.push_back("focus " + number_text(static_cast<double>(*position)) + " /m instead of " + number_text(*options.focus) +
                      " /m: the nearest that the lens takes");
  } else if (options.focus) {
    notes.push_back("focus cannot be set: the camera has no such control");
  } else if (lens) {
    notes.push_back("the lens stays where it is: camera.focus holds the one that the camera was calibrated with");
  }
  return concerns;
}

}  // namespace srd
