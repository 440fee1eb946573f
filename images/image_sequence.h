#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/event.h"
#include "recording/event_columns.h"

namespace saccade {

/// Properties of a sequence before its images are read.
struct ImageSequenceInfo {
  ImageSize size;                      ///< of every image
  std::int64_t count = 0;              ///< of images; 0 where a video has no count
  std::optional<double> images_per_s;  ///< of a video
  bool linear = false;                 ///< the values are linear luminance already, of any unit
  std::int64_t skipped_files = 0;      ///< files and folders in the folder that are no images
};

/// Images as linear luminance, read one by one; memory does not depend on their number. name_of() and info() may be
/// called while another thread reads.
///
///   folder  .bmp .exr .jpeg .jpg .pgm .png .ppm .tif .tiff, sorted by name with numbers by value; or the
///           named ones
///   .npy    NumPy array (images, height, width) of float32, float64, uint8 or uint16, little-endian, C order
///   video   whatever ffmpeg decodes, converted to 8 bit
///
/// Integer images and video are sRGB (IEC 61966-2-1): decoded to linear light and scaled so that their white is
/// `white`. Float images and .npy arrays of any type are linear luminance already. Colour becomes luminance
/// with the weights of Rec. 709 (0.2126, 0.7152, 0.0722) of linear red, green and blue; alpha is ignored.
class ImageSequence {
 public:
  virtual ~ImageSequence() = default;

  /// Replaces `luminance` by the next image, row by row; false after the last one. The values are not
  /// checked. Throws InputError for an image that cannot be decoded, or with another size or other numbers
  /// (8 or 16 bit, float) than the first.
  virtual bool read(std::vector<float>& luminance) = 0;
  /// When the image that read() gave last was taken, by a video's container, us from its start; none where there are no times, or
  /// all are those of images_per_s.
  [[nodiscard]] virtual std::optional<std::int64_t> time_us() const { return std::nullopt; }
  /// Of an image, counted from 0, for messages: "shots/f7.png, image 3", "ramp.npy, image 3".
  [[nodiscard]] virtual std::string name_of(std::int64_t image) const = 0;
  [[nodiscard]] const ImageSequenceInfo& info() const { return info_; }

 protected:
  ImageSequenceInfo info_;
};

/// When an image was taken.
struct ImageTime {
  std::int64_t t_us = 0;
  std::string name;   ///< of its file; empty where the table has none
  std::string place;  ///< file and line, for messages
};

/// Reads times, one a line and increasing, in `unit`, else in that of a first line of names ("#timestamp [ns],filename", "t_us"),
/// else a whole number is us, one with a decimal point s (one file keeps to one of them). A name may follow after blanks or a
/// comma; then every line has one. A byte order mark, empty lines and lines that start with # are skipped. Times lie
/// within 4e15 us of 0. Without a unit, whole times of which the median step is 1 s or longer as us, and those of
/// why_not_seconds(), are refused.
/// Throws InputError.
[[nodiscard]] std::vector<ImageTime> read_image_times(const std::filesystem::path& path,
                                                      std::optional<TimeUnit> unit = std::nullopt);

/// Opens a folder, a .npy file or a video. `white`: luminance of white, where values are not linear.
/// `named`: where it is not empty, these files of the folder in this order.
/// Throws InputError.
[[nodiscard]] std::unique_ptr<ImageSequence> open_image_sequence(const std::filesystem::path& path,
                                                                 double white,
                                                                 std::span<const ImageTime> named = {});

}  // namespace saccade
