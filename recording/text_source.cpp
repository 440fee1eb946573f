#include "recording/text_source.h"

#include <vector>

#include "recording/codec.h"

namespace saccade {
namespace {

bool is_text_name(const std::string& name) {
  std::string ending = name.substr(name.size() - std::min<std::size_t>(name.size(), 4));
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return (ending == ".txt" || ending == ".csv") && !name.starts_with("__MACOSX/");
}

}  // namespace

TextSource::TextSource(InputFile file)
    : file_(std::make_unique<InputFile>(std::move(file))), name_(file_->name()) {
  if (!file_->peek(zip_mark.size()).starts_with(zip_mark)) return;
  InputFile zip(name_);
  std::vector<ZipMember> texts;
  std::string contents;
  try {
    for_each_zip_member(zip, [&](const ZipMember& member) {
      contents += (contents.empty() ? "" : ", ") + printable(member.name);
      if (is_text_name(member.name)) texts.push_back(member);
      if (!zip.discard(member.stored_bytes)) zip.fail("the end of the file", "the rest of a member");
    });
  } catch (const InputError& error) {
    if (texts.empty()) throw;
    broken_ = error;
  }
  if (texts.size() != 1)
    throw InputError(name_, "a ZIP file of " + (contents.empty() ? "nothing" : contents),
                     "one text (.txt, .csv) or NumPy's arrays (.npy) in it");
  member_ = texts.front();
  name_ += ": " + printable(member_.name);
  if (!file_->discard(member_.place)) file_->fail("the end of the file", "the rest of a ZIP file");
  part_ = std::make_unique<UnpackedPart>(*file_);
  part_->begin(member_.decompressor(), member_.stored_bytes);
}

std::string_view TextSource::peek_in_zip(std::size_t wanted) {
  std::string_view bytes;
  try {
    bytes = part_->peek(failure_ ? 0 : std::min(wanted, UnpackedPart::window_bytes));
  } catch (const InputError& error) {
    failure_ = error;
    bytes = part_->peek(0);
  }
  if (failure_ && bytes.find('\n') == std::string_view::npos) throw InputError(*failure_);
  if (bytes.empty()) {
    if (part_->crc() != member_.crc)
      file_->fail("another checksum of " + printable(member_.name), "a sound text");
    if (broken_) throw InputError(*broken_);
  }
  return bytes;
}

}  // namespace saccade
