#pragma once

#include <hdf5.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <utility>

#include "recording/codec.h"
#include "recording/output_file.h"

namespace saccade {

/// An identifier of libhdf5, closed by the destructor.
class Hdf5Handle {
 public:
  Hdf5Handle() = default;
  Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

/// The innermost cause of libhdf5's last failure, as it states it.
inline std::string whole_hdf5_error() {
  std::string text;
  const auto take = [](unsigned, const H5E_error2_t* error, void* to) -> herr_t {
    if (error->desc != nullptr) *static_cast<std::string*>(to) = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, take, &text);
  return text;
}
/// The same for a message.
inline std::string last_hdf5_error() { return printable(whole_hdf5_error()); }

/// Throws DiskFull or RunError for a file that libhdf5 could not write.
[[noreturn]] inline void throw_unwritten(const std::filesystem::path& path) {
  const std::string why = whole_hdf5_error();
  const std::string message = path.string() + ": cannot be written: libhdf5: " + printable(why);
  for (const int cause : {ENOSPC, EDQUOT, EFBIG})
    if (why.find("errno = " + std::to_string(cause) + ",") != std::string::npos) throw DiskFull(message);
  throw RunError(message);
}

}  // namespace saccade
