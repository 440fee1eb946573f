#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recording/other_records.h"
#include "recording/output_file.h"

namespace saccade {

/// Writes what a recording holds besides events into files beside the converted one, `NAME.EXT`:
///
/// NAME.frames/  000000.png, ... (16 bits where the recording has more than 8; compressed frames as they are) and frames.csv
/// NAME.imu.csv, NAME.triggers.csv
///
/// A kind that the recording does not have makes no file, and with `force` deletes an older one. They appear with commit().
class OtherRecordsFiles final : public OtherRecords {
 public:
  /// `kinds`: "frames,imu,triggers" or some of them. Throws InputError for another word, and without `force` where one of the
  /// files exists.
  OtherRecordsFiles(const std::filesystem::path& out, std::string_view kinds, bool force);
  ~OtherRecordsFiles() override;

  [[nodiscard]] bool wants_frames() const override { return frames_.wanted; }
  [[nodiscard]] bool wants_inertial() const override { return imu_.wanted; }
  [[nodiscard]] bool wants_triggers() const override { return triggers_.wanted; }
  void add(const RecordedFrame& frame) override;
  void add(const InertialReading& reading) override;
  void add(const RecordedTrigger& trigger) override;

  /// All files appear. Returns a line about each wanted kind.
  [[nodiscard]] std::vector<std::string> commit();

 private:
  struct Kind {
    bool wanted = false;
    std::filesystem::path path;         ///< of the file, or of the folder of the frames
    std::unique_ptr<OutputFile> table;  ///< null before the first record
    std::int64_t count = 0;
  };
  OutputFile& table_of(Kind& kind, const std::filesystem::path& path, std::string_view columns);

  Kind frames_, imu_, triggers_;
  std::filesystem::path frames_part_;  ///< the folder until commit()
};

}  // namespace saccade
