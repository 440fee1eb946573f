#pragma once

#include <cstddef>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace saccade {

/// A file of XML with the places of its elements, and the problems that were found in it.
class XmlFile {
 public:
  /// Reads the file: at most 16 MiB of UTF-8. Throws InputError with the line where it is no XML or its root has another name.
  XmlFile(std::string path, std::string_view root);

  [[nodiscard]] pugi::xml_node root() const { return document_.document_element(); }
  [[nodiscard]] std::size_t line_of(const pugi::xml_node& element) const;
  /// "model.urdf:12: <joint name="neck">"
  [[nodiscard]] std::string place(const pugi::xml_node& element) const;

  void add(const pugi::xml_node& element, std::string found, std::string expectation) {
    problems_.push_back({place(element), std::move(found), std::move(expectation)});
  }
  void add(std::string found, std::string expectation) {
    problems_.push_back({path_, std::move(found), std::move(expectation)});
  }
  [[nodiscard]] bool has_problems() const { return !problems_.empty(); }
  /// Throws InputError with the problems when there are any.
  void throw_if_any() const {
    if (!problems_.empty()) throw InputError(problems_);
  }

 private:
  [[nodiscard]] std::size_t line_at(std::size_t offset) const;

  std::string path_;
  std::string text_;
  pugi::xml_document document_;
  std::vector<Problem> problems_;
};

/// The text of a file that is no longer than `most` bytes. Throws InputError where it cannot be read or is longer.
[[nodiscard]] std::string text_of_file(const std::string& path, std::size_t most,
                                       const std::string& expectation);

}  // namespace saccade
