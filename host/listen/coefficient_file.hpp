// SPDX-License-Identifier: Apache-2.0
// The coefficient file of a run, CSV. A row is safe once flush() has returned: the file's bytes are on the disk (fdatasync).
//
// One file has one list of modes. The first list that comes goes to the file that was asked for; a node with another list
// gets a file of its own beside it: run.csv, run.A00-B-C.csv. What a row does not say (lengths, origin, index of
// refraction, pattern) stands beside each file, in run.csv.model.toml (model_file.hpp).
//
// Opening to append reads which frames the files have, and cuts off a last line that was not written to its end.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "drivers/support/unique_fd.hpp"
#include "host/coefficients/frame_sink.hpp"
#include "host/coefficients/model_file.hpp"
#include "host/listen/sequence_set.hpp"

namespace srd::host {

enum class OpenMode : std::uint8_t { kNew, kReplace, kAppend };

class CoefficientFile final : public FrameSink {
 public:
  // kNew: kUsage when there is such a file already. kAppend: kInput when it is there and is no coefficient file.
  // What cannot be written: kDevice.
  [[nodiscard]] static Outcome<std::unique_ptr<CoefficientFile>> open(const std::filesystem::path& file, OpenMode mode);

  [[nodiscard]] Outcome<void> write(const proto::BootId& from, std::uint64_t sequence,
                                    const proto::CoefficientFrame& frame) override;
  [[nodiscard]] Outcome<void> flush() override;

  // What the files had when they were opened.
  [[nodiscard]] const std::map<proto::BootId, SequenceSet>& frames_in_file() const { return in_file_; }
  [[nodiscard]] std::vector<std::filesystem::path> files() const;
  // What a person should know at the end.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  struct File {
    std::filesystem::path path;
    UniqueFd fd;
    std::string pending;  // not written yet
    bool has_rows_to_sync = false;
    ModelFile models;
    std::set<proto::BootId> described;  // boots of this run whose model is in models
  };
  CoefficientFile(std::filesystem::path path, OpenMode mode) : path_(std::move(path)), mode_(mode) {}
  [[nodiscard]] Outcome<void> open_file(const std::filesystem::path& path, File& file);
  [[nodiscard]] Outcome<void> take_over(const std::filesystem::path& path);
  [[nodiscard]] std::vector<std::filesystem::path> further_files() const;
  [[nodiscard]] std::filesystem::path beside(const std::string& part) const;
  [[nodiscard]] Outcome<File*> file_for(const dsp::ModeList& modes);
  [[nodiscard]] Outcome<void> describe_model(const proto::BootId& from, const proto::CoefficientFrame& frame, File& file);
  [[nodiscard]] static Outcome<void> write_out(File& file);

  std::filesystem::path path_;
  OpenMode mode_;
  std::map<std::string, File> files_;  // by joined names of modes; "" until the first file knows its own
  std::vector<std::string> notes_;
  std::map<proto::BootId, SequenceSet> in_file_;
};

}  // namespace srd::host
