// SPDX-License-Identifier: Apache-2.0
#include "firmware/strobe/strobe.hpp"

#include <sys/prctl.h>

#include <sstream>

#include "firmware/service/stop_signals.hpp"

namespace srd::firmware {

Outcome<std::unique_ptr<Strobe>> Strobe::open(const StrobeSection& section, const FrameTiming& frame, double frame_rate_hz,
                                              const Region& region) {
  std::unique_ptr<OutputLine> strobe, trigger;
  if (!section.line.empty()) {
    auto line = open_gpiod_line(section.line_address(), "srd-node strobe");
    if (!line) return line.error();
    strobe = std::move(line).value();
  }
  if (section.mode == StrobeMode::kTrigger) {
    auto line = open_gpiod_line(section.trigger_address(), "srd-node trigger");
    if (!line) return line.error();
    trigger = std::move(line).value();
  }
  return std::make_unique<Strobe>(section, strobe_timing(section, frame, frame_rate_hz), region, std::move(strobe),
                                  std::move(trigger), std::make_unique<SystemStrobeClock>());
}

Strobe::Strobe(const StrobeSection& section, const StrobeTiming& timing, const Region& region,
               std::unique_ptr<OutputLine> strobe, std::unique_ptr<OutputLine> trigger, std::unique_ptr<StrobeClock> clock)
    : section_(section),
      strobe_(std::move(strobe)),
      trigger_(std::move(trigger)),
      clock_(std::move(clock)),
      scheduler_(timing, strobe_.get(), trigger_.get(), *clock_),
      labels_(section.pattern, section.dark_difference, region) {}

void Strobe::start(std::function<void()> enter) {
  const StopSignalsBlocked blocked;
  thread_ = std::thread([this, enter = std::move(enter)] {
    // An ordinary thread's sleeps end up to 50 us late on purpose, unless it says otherwise; a real-time one's do not.
    (void)::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
    if (enter) enter();
    scheduler_.run();
  });
}

void Strobe::stop() {
  scheduler_.stop();
  if (thread_.joinable()) thread_.join();
}

void Strobe::captured(const CameraFrame& frame) noexcept {
  // Only a clock of this board tells when the next frames will be.
  if (frame.clock == ClockId::kUnknown || frame.clock == ClockId::kRecording) return;
  if (frame.time_ns > clock_->now_ns() + clock_->offset_ns(frame.clock)) early_.fetch_add(1, std::memory_order_relaxed);
  scheduler_.offer({frame.sequence, frame.time_ns, frame.clock});
}

void Strobe::label(CameraFrame& frame) noexcept {
  SpscRing<StrobePulse>& pulses = scheduler_.pulses();
  while (const StrobePulse* pulse = pulses.front()) {
    labels_.add(*pulse);
    pulses.pop();
  }
  // Triggers without a strobe say nothing of light.
  if (strobe_ != nullptr) labels_.label(frame);
}

StrobeReport Strobe::report() const {
  const auto value = [](const auto& counter) { return counter.load(std::memory_order_relaxed); };
  const StrobeCounters& c = scheduler_.counters();
  const LabelCounters& l = labels_.counters();
  StrobeReport report;
  report.mode = section_.mode;
  report.lock = value(c.lock);
  report.rate_hz = value(c.period_ns) > 0 ? 1e9 / static_cast<double>(value(c.period_ns)) : 0;
  report.jitter_us = static_cast<double>(value(c.jitter_ns)) / 1e3;
  report.uncertainty_us = static_cast<double>(value(c.uncertainty_ns)) / 1e3;
  report.locks = value(c.locks), report.rejected = value(c.rejected), report.slips = value(c.slips);
  report.pulses = value(c.pulses), report.dark = value(c.dark), report.late = value(c.late);
  report.skipped = value(c.skipped), report.withheld = value(c.withheld);
  report.overlong = value(c.overlong), report.spilled = value(c.spilled);
  report.longest_us = static_cast<double>(value(c.longest_ns)) / 1e3;
  report.triggers = value(c.triggers), report.triggers_missed = value(c.triggers_missed);
  report.untriggered = value(c.untriggered), report.wall_steps = value(c.wall_steps);
  report.lit_frames = value(l.lit), report.dark_frames = value(l.dark), report.unlit = value(l.unlit);
  report.unlabelled = value(l.unlabelled), report.mislabelled = value(l.mislabelled), report.resyncs = value(l.resyncs);
  report.shift = labels_.shift();
  report.early = value(early_);
  report.lit_level = value(l.lit_level) / 16.0, report.dark_level = value(l.dark_level) / 16.0;
  report.lateness = scheduler_.lateness().text();
  for (const OutputLine* line : {strobe_.get(), trigger_.get()})
    if (line != nullptr) report.faults += line->faults();
  return report;
}

std::string StrobeReport::text() const {
  if (mode == StrobeMode::kOff) return {};
  std::ostringstream out;
  out.precision(4);
  if (mode == StrobeMode::kFollow)
    out << "strobe    " << to_string(lock) << ", " << rate_hz << " Hz, stamps to " << jitter_us << " us, predicted to "
        << uncertainty_us << " us; locked " << locks << " times, " << rejected << " stamps rejected, " << slips
        << " frames slipped\n";
  else
    out << "trigger   " << triggers << " triggers, " << triggers_missed << " without a frame, " << untriggered
        << " frames without a trigger, " << wall_steps << " steps of the wall clock\n";
  out << "pulses    " << pulses << ", " << late << " late, " << skipped << " skipped, " << withheld
      << " withheld for the duty, " << overlong << " beyond max_pulse_us, " << spilled << " past the exposure, longest "
      << longest_us << " us\n"
      << "lateness  " << lateness << "\n"
      << "light     " << lit_frames << " frames lit, " << dark_frames << " dark, " << unlit << " without their pulse, "
      << unlabelled << " unstrobed, " << mislabelled << " mislabelled, " << resyncs << " times resynchronised";
  if (shift != 0) out << " (light of " << shift << " exposures on: check camera.stamp)";
  if (lit_level > 0) out << "; level " << lit_level << " lit, " << dark_level << " dark";
  out << "\n";
  if (early > 0)
    out << "stamps    " << early
        << " frames came before the middle of their exposure: check camera.stamp and camera.readout_us\n";
  if (faults > 0) out << "line      " << faults << " times the GPIO line could not be switched\n";
  return out.str();
}

Outcome<void> check_strobe(const StrobeSection& section, bool live, const std::string& file) {
  if (section.mode == StrobeMode::kOff || !live || !gpiod_version().empty()) return {};
  return Problem{
      Exit::kUsage,  std::string("strobe.mode is \"") + to_string(section.mode) + "\", and this build has no GPIO lines",
      file,          "a program built with libgpiod",
      "one without", "install libgpiod-dev and build again, or set strobe.mode = \"off\""};
}

std::string summary_of(const StrobeSection& section, bool live) {
  if (section.mode == StrobeMode::kOff) return {};
  if (!live) return "strobe    not used: these frames take no light from this board\n";
  std::ostringstream out;
  out << "strobe    " << to_string(section.mode);
  if (!section.line.empty())
    out << ", " << section.line_address().text() << ", " << section.pulse_us << " us, pattern " << section.pattern_text;
  if (section.mode == StrobeMode::kTrigger) out << ", trigger on line " << section.trigger_line;
  out << ", " << gpiod_version() << "\n";
  return out.str();
}

}  // namespace srd::firmware
