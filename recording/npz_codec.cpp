#include "recording/npz_codec.h"

#include <algorithm>
#include <limits>

#include "recording/block_reader.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/npy_columns.h"

namespace saccade {
namespace {

constexpr std::uint64_t most_rows = std::uint64_t{1} << 48;

/// The arrays of a file that matter: those of events and of the image size.
class NpyFile {
 public:
  explicit NpyFile(const EventReadOptions& options)
      : letters_(options.columns == EventReadOptions{}.columns ? "txyp" : options.columns),
        unit_(options.time_unit) {}

  /// Takes an array whose stored bytes begin here. Reads to its end.
  void take_member(InputFile& file, const ZipMember& member) {
    UnpackedPart part(file);
    part.begin(member.decompressor(), member.stored_bytes);
    take(part, file, member);
    if (!part.discard_rest()) file.fail("the end of the file", "the rest of " + printable(member.name));
  }

  /// Whether there are columns for events.
  [[nodiscard]] bool complete() const {
    return std::ranges::all_of(std::array{EventColumn::t, EventColumn::x, EventColumn::y, EventColumn::p},
                               [&](EventColumn column) { return has(column); });
  }
  [[nodiscard]] const std::vector<NpyArray>& arrays() const { return arrays_; }
  [[nodiscard]] std::optional<ImageSize> image_size() const { return image_size_; }
  /// What there is, for messages.
  [[nodiscard]] std::string contents() const { return contents_.empty() ? "no arrays" : contents_; }

  /// Takes the array in `part`, of which at least the header is read.
  void take(UnpackedPart& part, const InputFile& file, const ZipMember& member) {
    std::string name = member.name;
    if (name.ends_with(".npy")) name.resize(name.size() - 4);
    NpyArray array;
    array.member = member;
    const NpyHeader header = read_npy_header(part, file, array.header_bytes);
    contents_ +=
        (contents_.empty() ? "" : ", ") + printable(name.empty() ? "an array" : name) + description(header);
    if (take_size(name, header, part)) return;
    if (header.shape.empty()) return;
    array.rows = static_cast<std::uint64_t>(header.shape[0]);
    if (array.rows > most_rows || !lay_out(name, header, array) || array.columns.empty()) return;
    const bool is_new = std::ranges::none_of(
        array.columns, [&](const NpyArray::Column& column) { return has(column.column); });
    if (!is_new) return;
    if (header.fortran_order && header.shape.size() == 2) {
      add_columns(array);
    } else {
      arrays_.push_back(std::move(array));
    }
  }

 private:
  [[nodiscard]] bool has(EventColumn column) const {
    return std::ranges::any_of(arrays_, [column](const NpyArray& array) {
      return std::ranges::count(array.columns, column, &NpyArray::Column::column) > 0;
    });
  }

  static std::string description(const NpyHeader& header) {
    std::string text = " (";
    for (const std::int64_t length : header.shape) text += std::to_string(length) + " x ";
    if (header.fields.empty()) return text + printable(header.type) + ")";
    for (const auto& field : header.fields)
      text += (&field == &header.fields[0] ? "" : " ") + printable(field.name);
    return text + ")";
  }

  /// Of an array in Fortran order: its columns, which follow each other.
  void add_columns(const NpyArray& array) {
    for (const NpyArray::Column& column : array.columns) {
      NpyArray alone = array;
      alone.row_bytes = column.number.bytes;
      alone.header_bytes += array.rows * column.offset;
      alone.to_end = column.offset + column.number.bytes == array.row_bytes;
      alone.columns = {column};
      alone.columns[0].offset = 0;
      arrays_.push_back(std::move(alone));
    }
  }

  /// Adds a column at the end of the row; the first one of two that are the same is read.
  void add_column(EventColumn column, const NpyNumber& number, std::optional<TimeUnit> named,
                  NpyArray& array) const {
    if (std::ranges::count(array.columns, column, &NpyArray::Column::column) > 0) return;
    const std::optional<TimeUnit> stated = unit_ ? unit_ : number.unit ? number.unit : named;
    array.columns.push_back({column, number, array.row_bytes, stated});
  }

  /// True where the array holds the image size.
  bool take_size(const std::string& name, const NpyHeader& header, UnpackedPart& part) {
    const bool is_pair = name == "sensor_size" && header.shape.size() == 1 && header.shape[0] >= 2;
    const bool is_length = (name == "width" || name == "height") && header.shape.empty();
    const auto number = NpyNumber::parse(header.type);
    if ((!is_pair && !is_length) || !number) return false;
    const std::size_t bytes = number->bytes * (is_pair ? 2 : 1);
    const std::string_view ahead = part.peek(bytes);
    if (ahead.size() < bytes) return true;
    const auto length = [&](std::size_t i) {
      constexpr std::int64_t longest_px = 1 << 16;
      const std::int64_t px = number->value(ahead.data() + i * number->bytes).value_or(0);
      return px > 0 && px <= longest_px ? static_cast<int>(px) : 0;
    };
    if (is_pair || name == "width") size_.width = length(0);
    if (is_pair) size_.height = length(1);
    if (name == "height") size_.height = length(0);
    if (size_.width > 0 && size_.height > 0) image_size_ = size_;
    return true;
  }

  /// Finds the columns of events in an array; false where one of them has another type.
  [[nodiscard]] bool lay_out(const std::string& name, const NpyHeader& header, NpyArray& array) const {
    if (!header.fields.empty() && header.shape.size() == 1) {
      for (const NpyHeader::Field& field : header.fields) {
        const auto bytes = npy_type_bytes(field.type);
        if (!bytes) return false;
        auto named = event_column(field.name);
        if (!named) named = event_column(field.title);
        if (named) {
          const auto number = NpyNumber::parse(field.type);
          if (!number) return false;
          add_column(named->column, *number, named->unit, array);
        }
        array.row_bytes += *bytes;
      }
      return array.row_bytes <= UnpackedPart::window_bytes;
    }
    const auto number = NpyNumber::parse(header.type);
    if (!number) return false;
    if (header.shape.size() == 1) {
      const auto named = event_column(name);
      if (named) add_column(named->column, *number, named->unit, array);
      array.row_bytes = number->bytes;
      return true;
    }
    if (header.shape.size() != 2 || header.shape[1] != static_cast<std::int64_t>(letters_.size()))
      return false;
    for (const char letter : letters_) {
      const auto named = event_column(letter == 'c' ? "camera" : std::string_view(&letter, 1));
      if (named) add_column(named->column, *number, {}, array);
      array.row_bytes += number->bytes;
    }
    return true;
  }

  std::string letters_;
  std::optional<TimeUnit> unit_;
  std::vector<NpyArray> arrays_;
  ImageSize size_;
  std::optional<ImageSize> image_size_;
  std::string contents_;
};

class NumpyReader final : public BlockReader {
 public:
  NumpyReader(InputFile input, const EventReadOptions& options) : BlockReader(std::move(input)) {
    NpyFile arrays(options);
    is_zip_ = file_.peek(1).starts_with(zip_mark[0]);
    try {
      if (is_zip_) {
        for_each_zip_member(file_, [&](const ZipMember& member) {
          if (member.name.ends_with(".npy")) {
            arrays.take_member(file_, member);
          } else if (!file_.discard(member.stored_bytes)) {
            file_.fail("the end of the file", "the rest of a member");
          }
        });
      } else {
        UnpackedPart part(file_);
        ZipMember whole;
        whole.stored_bytes = std::numeric_limits<std::uint64_t>::max();
        part.begin(make_copier(), whole.stored_bytes);
        arrays.take(part, file_, whole);
      }
    } catch (const InputError& error) {
      if (!arrays.complete()) throw;
      broken_ = error;
    }
    image_size_ = arrays.image_size() ? arrays.image_size() : options.image_size;
    if (!arrays.complete()) {
      throw InputError(
          file_.name(), arrays.contents(),
          "records with the fields t, x, y and p, arrays with these names, or one array with the columns of "
          "--columns, " +
              options.columns);
    }
    for (const NpyArray& array : arrays.arrays()) {
      if (array.rows != arrays.arrays().front().rows)
        throw InputError(file_.name(), arrays.contents(), "arrays of events with the same number of rows");
      sources_.push_back(std::make_unique<NpyRows>(file_.name(), array));
    }
    rows_left_ = arrays.arrays().front().rows;
    check_times();
  }

  [[nodiscard]] std::optional<ImageSize> image_size() const override { return image_size_; }
  [[nodiscard]] std::string format() const override { return is_zip_ ? "NumPy NPZ" : "NumPy NPY"; }

 protected:
  bool decode(std::span<Event> block, std::size_t& count) override {
    if (rows_left_ == 0) {
      for (const auto& source : sources_) source->check_end();
      if (broken_) throw InputError(*broken_);
      return false;
    }
    std::size_t rows = static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), rows_left_));
    for (const auto& source : sources_)
      rows = std::min(rows, source->ahead(rows).size() / source->array().row_bytes);
    if (rows == 0) {
      for (const auto& source : sources_) {
        if (source->ahead(1).empty()) source->check_end();
      }
      file_.fail("the end of an array " + std::to_string(rows_left_) + " rows early", "all of its rows");
    }
    for (std::size_t i = 0; i < rows; ++i) block[i] = {};
    for (const auto& source : sources_) {
      const char* at = source->ahead(rows).data();
      for (const NpyArray::Column& column : source->array().columns)
        rows = std::min(
            rows, read_column(column, at + column.offset, source->array().row_bytes, block.first(rows)));
    }
    count = rows;
    if (bad_value_) {
      rows_left_ -= rows;
      throw InputError(file_.name() + ": row " + std::to_string(row_ + rows), *bad_value_,
                       bad_value_expectation_);
    }
    for (const auto& source : sources_) source->skip(rows);
    rows_left_ -= rows;
    row_ += rows;
    return true;
  }

 private:
  /// Throws where floating-point times without a unit are hardly s.
  void check_times() {
    for (const auto& source : sources_) {
      const NpyArray& array = source->array();
      const auto t = std::ranges::find(array.columns, EventColumn::t, &NpyArray::Column::column);
      if (t == array.columns.end() || t->unit || t->number.kind != NpyNumber::Kind::real) continue;
      const std::string_view rows =
          source->ahead(static_cast<std::size_t>(std::min<std::uint64_t>(block_events, array.rows)));
      std::vector<double> times;
      for (std::size_t at = t->offset; at < rows.size(); at += array.row_bytes)
        times.push_back(t->number.real(rows.data() + at));
      const std::string why = why_not_seconds(times);
      if (!why.empty()) throw InputError(file_.name(), why, std::string(unit_expectation));
    }
  }

  /// Number of rows before one with a value that no event has.
  std::size_t read_column(const NpyArray::Column& column, const char* at, std::size_t row_bytes,
                          std::span<Event> block) {
    constexpr std::int64_t largest_px = 65535;
    const bool is_time = column.column == EventColumn::t;
    const TimeUnit unit = column.unit_or_default();
    for (std::size_t i = 0; i < block.size(); ++i, at += row_bytes) {
      Event& event = block[i];
      const auto value = is_time ? column.number.time_us(at, unit) : column.number.value(at);
      bool fits = value.has_value();
      switch (column.column) {
        case EventColumn::t:
          fits = fits && (column.unit || (*value <= longest_plausible_us && *value >= -longest_plausible_us));
          event.t_us = value.value_or(0);
          break;
        case EventColumn::p:
          event.on = value.value_or(0) > 0;
          break;
        case EventColumn::camera:
          fits = fits && (*value == 0 || *value == 1);
          event.camera = static_cast<std::uint8_t>(value.value_or(0));
          break;
        case EventColumn::x:
        case EventColumn::y:
          fits = fits && *value >= 0 && *value <= largest_px;
          (column.column == EventColumn::x ? event.x : event.y) =
              static_cast<std::uint16_t>(value.value_or(0));
          break;
      }
      if (fits) continue;
      constexpr std::array<const char*, event_columns> names = {"t", "x", "y", "p", "camera"};
      bad_value_ = std::string(names[static_cast<std::size_t>(column.column)]) + " = " +
                   (value ? std::to_string(*value) : "no number within 2^62");
      if (is_time && value) bad_value_expectation_ = unit_expectation;
      return i;
    }
    return block.size();
  }

  bool is_zip_ = false;
  std::optional<ImageSize> image_size_;
  std::vector<std::unique_ptr<NpyRows>> sources_;
  std::uint64_t rows_left_ = 0;
  std::uint64_t row_ = 0;  ///< that comes next
  std::optional<std::string> bad_value_;
  std::string bad_value_expectation_ = "x and y from 0 to 65535, camera 0 or 1, times within 2^62 us";
  std::optional<InputError> broken_;  ///< what is wrong with the file behind the events
};

/// Whether a ZIP file begins with an array.
Match npz_match(const FileStart& start) {
  constexpr std::size_t name_place = 30;
  const Match zip = start.begins_with(zip_mark);
  if (zip != Match::certain) return zip;
  if (start.bytes.size() < name_place) return Match::cut_off;
  const auto name_bytes = load_little<std::uint16_t>(start.bytes.data() + 26);
  if (start.bytes.size() < name_place + name_bytes) return Match::cut_off;
  return start.bytes.substr(name_place, name_bytes).ends_with(".npy") ? Match::certain : Match::none;
}

}  // namespace

RecordingFormat numpy_format() {
  RecordingFormat format;
  format.name = "NumPy";
  format.extensions = {".npz", ".npy"};
  format.sniff = [](const FileStart& start) {
    return std::max(npz_match(start), start.begins_with(npy_mark));
  };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<NumpyReader>(std::move(file), options);
  };
  format.create = create_numpy;
  format.cameras = 2;
  format.reads =
      "records with the fields t, x, y, p (tonic's layout; `on`, titles and units such as `t_ns` too), "
      "arrays with these "
      "names, or one array in C or Fortran order with the columns of "
      "`--columns`; deflated or not; image size from `sensor_size` or `width` and `height`";
  format.writes =
      "records of u16 x, u16 y, i64 t, bool p and with two cameras u8 camera; `.npz` deflated as `events`, "
      "with `sensor_size`";
  format.time =
      "in the unit of the name, of datetime64 or of `--time-unit`, else whole numbers us, floating-point s";
  format.axes = "top left, above 0 is ON";
  return format;
}

}  // namespace saccade
