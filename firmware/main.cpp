// SPDX-License-Identifier: Apache-2.0
// srd-node: measures the water surface in front of one camera and sends it to the host.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>

#include "drivers/camera/simulator/scene_truth.hpp"
#include "drivers/net/address.hpp"
#include "drivers/support/text_file.hpp"
#include "firmware/config/camera_factory.hpp"
#include "firmware/config/node_key.hpp"
#include "firmware/doctor/doctor.hpp"
#include "firmware/node/node.hpp"
#include "firmware/service/last_end.hpp"
#include "firmware/service/stop_signals.hpp"
#include "firmware/stills/still_requests.hpp"
#include "firmware/stills/stills.hpp"
#include "firmware/strobe/lines_low.hpp"

namespace {

std::atomic<bool> stop_requested{false};
std::atomic<int> stop_signal{0};  // that came first
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

// The first time ends in order; SIGINT again ends at once.
void request_stop(int signal) {
  int none = 0;
  if (stop_signal.compare_exchange_strong(none, signal)) {
    stop_requested = true;
    return;
  }
  if (signal != SIGINT) return;
  srd::firmware::LastEnd::clear_from_signal();
  ::_exit(128 + SIGINT);
}

int fail(const srd::Problem& problem) {
  std::fputs(problem.text().c_str(), stderr);
  return static_cast<int>(problem.exit);
}

struct Arguments {
  std::string config, camera, host, truth, record, state, stills;
  std::vector<std::string> rates;
  std::uint64_t frames = 0, count = 0;
  std::optional<double> every_s;
  bool check = false, strobe_low = false, list = false, force = false, doctor = false;
};

// What the command line says goes before what the file says.
srd::Outcome<void> override_config(const Arguments& arguments, srd::firmware::NodeConfig& config) {
  if (!arguments.camera.empty()) {
    auto source = srd::firmware::CameraSource::parse(arguments.camera);
    if (!source) {
      source.error().where = "--camera";
      return source.error();
    }
    config.camera = *source;
  }
  if (!arguments.host.empty()) config.host = arguments.host;
  for (const std::string& rate : arguments.rates) {
    if (rate == "max" || rate == "camera") {
      config.pace = rate == "max" ? srd::Pace::kMax : srd::Pace::kCamera;
      continue;
    }
    config.recording_rate_hz = srd::parse_number<double>(rate);
    if (config.camera && config.camera->kind != "recording")
      return srd::Problem{srd::Exit::kUsage,
                          "--rate HZ is for recordings",
                          "--rate",
                          "camera or max",
                          rate,
                          "the rate of a live camera is camera.frame_rate_hz, of the simulator its scene's"};
  }
  if (!arguments.record.empty()) {
    config.recording.folder = arguments.record;
    config.recording.numbered_folders = false;
  }
  config.recording.force = arguments.force;
  if (!arguments.state.empty()) config.state = arguments.state;
  if (config.state.empty()) config.state = srd::firmware::LastEnd::service_folder();
  return {};
}

// A name without an address is refused where a person waits for the end. A live camera does not wait: the network may come
// up after the board, and the name is looked up while the node measures.
srd::Outcome<void> check_host(const Arguments& arguments, const srd::firmware::NodeConfig& config) {
  if (config.host.empty()) return {};
  const std::string where = arguments.host.empty() ? config.file.string() : "--host";
  const auto host = srd::HostAndPort::parse(config.host, where);
  if (!host) return host.error();
  if (host->port == 0)
    return srd::Problem{srd::Exit::kUsage,
                        "no port to send to",
                        where,
                        "HOST:PORT with a port of 1..65535",
                        "'" + config.host + "'",
                        "the port of srd listen, 47810 unless it was given another"};
  const bool live = config.camera && config.camera->live();
  if (live && !arguments.check) return {};
  const auto address = srd::Address::parse(config.host, where);
  if (address) return {};
  if (!arguments.check) return address.error();
  std::fprintf(stderr, "note      %s: %s\n", where.c_str(), address.error().what.c_str());
  return {};
}

int report_on(const srd::firmware::RunReport& report, const Arguments& arguments, const srd::firmware::NodeConfig& config,
              const srd::firmware::Instrument& instrument) {
  const std::string host = config.host, source = config.camera->text();
  std::fputs(report.text().c_str(), stderr);
  if (!arguments.truth.empty())
    if (auto written = srd::write_truth(arguments.truth, srd::truth_of(*instrument.scene, report.records)); !written)
      return fail(written.error());
  if (report.sent && report.transmitter.unacknowledged + report.transmitter.counts.lost + report.dropped_transmit > 0)
    return fail(
        {srd::Exit::kNetwork, "not every frame is in the host's record", host, "all acknowledged",
         std::to_string(report.transmitter.unacknowledged) + " frames not acknowledged, " +
             std::to_string(report.transmitter.counts.lost) + " overwritten, " + std::to_string(report.dropped_transmit) +
             " given up on the way to the sender",
         report.transmitter.host_problem.empty() ? "is srd listen running there?" : "a numeric address, or srd-node --doctor"});
  // A run that was stopped has said it above: a service that ends in order has not failed.
  if (!report.without_surface.empty() && !stop_requested)
    return fail({srd::Exit::kInput, "nothing was measured: no frame has a surface", source,
                 "frames that show the pattern through the water", report.without_surface,
                 "srd-node --doctor with this configuration looks at camera, light and pattern"});
  return 0;
}

srd::Outcome<srd::firmware::RunReport> measure(const srd::firmware::NodeConfig& config, const Arguments& arguments,
                                               srd::firmware::Instrument& instrument, const srd::firmware::LastEnd& last_end) {
  if (last_end.restarts() > 0) std::fprintf(stderr, "restart   %u, after: %s\n", last_end.restarts(), last_end.text().c_str());
  srd::firmware::RunOptions options;
  options.frames = arguments.frames;
  options.version = SRD_VERSION;
  options.restart = {last_end.text(), last_end.restarts()};
  options.notify = [](const std::string& lines) { std::fputs(lines.c_str(), stderr); };
  last_end.catch_fatal_signals();
  return srd::firmware::run_node(config, instrument, options, stop_requested);
}

// Tells everything, whatever fails. Stopped, it has not, and ends as by that signal.
int examine(const Arguments& arguments) {
  srd::firmware::Diagnosis diagnosis([](const srd::firmware::Finding& finding) {
    std::fputs(finding.text().c_str(), stdout);
    std::fflush(stdout);
  });
  srd::firmware::DoctorOptions options;
  options.stop = &stop_requested;
  if (arguments.config.empty()) {
    srd::firmware::examine(nullptr, options, diagnosis);
  } else {
    auto config = srd::firmware::NodeConfig::load(arguments.config);
    if (config)
      if (auto overridden = override_config(arguments, *config); !overridden) config = overridden.error();
    srd::firmware::examine(&config, options, diagnosis);
  }
  if (stop_requested) {
    std::fputs("stopped: not everything is examined\n", stderr);
    return 128 + stop_signal;
  }
  return static_cast<int>(diagnosis.exit());
}

int take_stills(const Arguments& arguments, const srd::firmware::NodeConfig& config) {
  srd::firmware::StillRequests requests;
  srd::firmware::StillsOptions options;
  options.folder = arguments.stills;
  options.every_s = arguments.every_s;
  options.count = arguments.count;
  options.asked = [&requests] { return requests.asked(); };
  options.notify = [](const std::string& lines) { std::fputs(lines.c_str(), stderr); };
  std::fprintf(stderr, "stills    to %s; Enter takes one, and so does kill -USR1 %d; Ctrl-C ends\n", arguments.stills.c_str(),
               static_cast<int>(::getpid()));
  const auto report = srd::firmware::run_stills(config, options, stop_requested);
  return report ? 0 : fail(report.error());
}

int run(const Arguments& arguments) {
  if (arguments.list) {
    std::fputs(srd::firmware::list_cameras().c_str(), stdout);
    return 0;
  }
  // Before anything has a line: one that is on when the program dies may stay on.
  srd::firmware::call_on_stop_signals(request_stop);
  if (arguments.doctor) return examine(arguments);
  if (arguments.config.empty())
    return fail({srd::Exit::kUsage, "no configuration", "--config", "a file", "none", "see board/ for profiles"});
  auto config = srd::firmware::NodeConfig::load(arguments.config);
  if (!config) return fail(config.error());
  if (arguments.strobe_low) {
    const auto low = srd::firmware::switch_lines_low(config->strobe);
    return low ? 0 : fail(low.error());
  }
  if (auto overridden = override_config(arguments, *config); !overridden) return fail(overridden.error());
  if (!arguments.stills.empty()) return take_stills(arguments, *config);
  if (auto good = check_host(arguments, *config); !good) return fail(good.error());
  if (const auto key = srd::firmware::read_node_key(*config); !key) return fail(key.error());
  const auto last_end = srd::firmware::LastEnd::open(arguments.check ? "" : config->state);
  if (!last_end) return fail(last_end.error());
  // From here on a run that does not come to its end leaves the reason for the next one.
  const auto ended = [&](const srd::Problem& problem) {
    last_end->write(problem.what + (problem.where.empty() ? "" : ": " + problem.where));
    return fail(problem);
  };
  auto instrument = srd::firmware::make_instrument(*config);
  if (!instrument) return ended(instrument.error());
  std::fputs(instrument->summary.c_str(), stderr);
  if (arguments.check) {
    if (!config->host.empty())
      std::fprintf(stderr, "key       %s\n",
                   config->key.empty() ? "none: the host cannot tell who sends" : config->key.string().c_str());
    std::puts("configuration is good");
    return 0;
  }
  if (!arguments.truth.empty() && !instrument->scene)
    return ended({srd::Exit::kUsage, "only the simulator knows the true surface", "--truth", "a camera of kind simulator",
                  config->camera->kind, ""});
  const auto report = measure(*config, arguments, *instrument, *last_end);
  if (!report) return ended(report.error());
  last_end->clear();
  return report_on(*report, arguments, *config, *instrument);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Measures the water surface in front of one camera and sends its coefficients to the host."};
  app.set_version_flag("--version", SRD_VERSION);
  Arguments arguments;
  app.add_option("--config", arguments.config, "Configuration, TOML");
  app.add_option("--camera", arguments.camera, "Camera instead of the file's: " + srd::firmware::CameraSource::kinds());
  app.add_option("--host", arguments.host, "ADDR:PORT of srd listen, instead of the file's");
  app.add_option("--frames", arguments.frames, "End after so many frames")->check(CLI::PositiveNumber);
  app.add_option(
         "--rate", arguments.rates,
         "How fast. camera: at the recorded rate; max: as fast as possible, dropping nothing; HZ: times of a recording follow "
         "from its sequence at this rate, those in frames.csv are not used. HZ and max may both be given")
      ->expected(1)
      ->take_all()
      ->check(CLI::Validator(
          [](std::string& text) -> std::string {
            if (text == "camera" || text == "max") return {};
            const auto rate = srd::parse_number<double>(text);
            if (rate && *rate >= 0.001 && *rate <= 10000) return {};
            return text + " is not camera, max or a rate from 0.001 to 10000 Hz";
          },
          "", "rate"));
  app.add_option("--truth", arguments.truth, "With the simulator: write the true surfaces to this CSV file");
  app.add_option("--record", arguments.record, "Keep the camera's frames in this folder, which can be replayed");
  app.add_flag("--force", arguments.force, "With --record: replace a recording that is there");
  CLI::Option* stills =
      app.add_option("--stills", arguments.stills,
                     "Take images for srd calibrate and srd pose into this folder, each of a board that is sharp "
                     "and stands still; measure nothing");
  app.add_option("--every", arguments.every_s, "With --stills: take one every so many seconds, not only when asked")
      ->needs(stills)
      ->check(CLI::Range(0.1, 86400.0));
  app.add_option("--count", arguments.count, "With --stills: end after so many")->needs(stills)->check(CLI::PositiveNumber);
  app.add_option("--state", arguments.state, "Folder that keeps how the last run ended, instead of the file's");
  app.add_flag("--check-config", arguments.check, "Read everything the configuration names, then end");
  app.add_flag("--doctor", arguments.doctor, "Examine camera, GPIO, clock, permissions, network and disk, say what to do");
  app.add_flag("--strobe-low", arguments.strobe_low, "Switch the configuration's strobe and trigger lines off, then end");
  app.add_flag("--list-cameras", arguments.list, "The kinds of camera, and the cameras that are there");
  for (const char* other : {"--record", "--frames", "--truth", "--check-config", "--doctor"})
    stills->excludes(app.get_option(other));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : static_cast<int>(srd::Exit::kUsage);
  }
  return run(arguments);
}
