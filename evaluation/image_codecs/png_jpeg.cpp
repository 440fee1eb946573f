#include "evaluation/image_codecs/png_jpeg.h"

#include <cstdio>  // jpeglib.h needs it

#include <jpeglib.h>
#include <png.h>

#include <csetjmp>
#include <cstdlib>
#include <cstring>

namespace saccade {
namespace {

constexpr int jpeg_quality = 85;
constexpr std::size_t most_pixels = std::size_t{1} << 30;  // as OpenCV's readers

using Bytes = std::vector<unsigned char>;

/// Leaves libpng without its line on the standard error output.
void leave(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void pass_over(png_structp, png_const_charp) {}

struct PngWriter {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, leave, pass_over);
  png_infop info = png_create_info_struct(png);
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
};

void append(png_structp png, png_bytep data, png_size_t size) {
  auto& bytes = *static_cast<Bytes*>(png_get_io_ptr(png));
  bytes.insert(bytes.end(), data, data + size);
}

bool encode_png(const cv::Mat& image, PngSize size, Bytes& bytes) {
  PngWriter writer;
  std::vector<png_bytep> rows(static_cast<std::size_t>(image.rows));
  for (int y = 0; y < image.rows; ++y)
    rows[static_cast<std::size_t>(y)] = const_cast<png_bytep>(image.ptr(y));
  if (setjmp(png_jmpbuf(writer.png))) return false;  // NOLINT: libpng's way of failing
  png_set_write_fn(writer.png, &bytes, append, nullptr);
  if (size == PngSize::small) {
    png_set_compression_level(writer.png, 6);
    png_set_compression_strategy(writer.png, 0);  // zlib's Z_DEFAULT_STRATEGY
  } else {
    png_set_filter(writer.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_set_compression_level(writer.png, 1);
    png_set_compression_strategy(writer.png, 3);  // zlib's Z_RLE
  }
  const int colour = image.channels() == 1   ? PNG_COLOR_TYPE_GRAY
                     : image.channels() == 3 ? PNG_COLOR_TYPE_RGB
                                             : PNG_COLOR_TYPE_RGBA;
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(image.cols),
               static_cast<png_uint_32>(image.rows), image.depth() == CV_16U ? 16 : 8, colour,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(writer.png, writer.info);
  png_set_bgr(writer.png);
  png_set_swap(writer.png);  // 16-bit values are big-endian in the file
  png_write_image(writer.png, rows.data());
  png_write_end(writer.png, writer.info);
  return true;
}

struct JpegError {
  jpeg_error_mgr manager{};
  std::jmp_buf place{};
};

jpeg_error_mgr* jpeg_errors(JpegError& error) {
  jpeg_std_error(&error.manager);
  error.manager.error_exit = [](j_common_ptr info) {
    std::longjmp(reinterpret_cast<JpegError*>(info->err)->place, 1);  // NOLINT: libjpeg's way of failing
  };
  error.manager.output_message = [](j_common_ptr) {};
  return &error.manager;
}

bool encode_jpeg(const cv::Mat& image, Bytes& bytes) {
  if (image.depth() != CV_8U || (image.channels() != 1 && image.channels() != 3)) return false;
  JpegError error;
  jpeg_compress_struct info{};
  unsigned char* buffer = nullptr;
  unsigned long size = 0;  // NOLINT: libjpeg's type
  info.err = jpeg_errors(error);
  jpeg_create_compress(&info);
  const bool done = setjmp(error.place) == 0;  // NOLINT
  if (done) {
    jpeg_mem_dest(&info, &buffer, &size);
    info.image_width = static_cast<JDIMENSION>(image.cols);
    info.image_height = static_cast<JDIMENSION>(image.rows);
    info.input_components = image.channels();
    info.in_color_space = image.channels() == 1 ? JCS_GRAYSCALE : JCS_EXT_BGR;
    jpeg_set_defaults(&info);
    jpeg_set_quality(&info, jpeg_quality, TRUE);
    jpeg_start_compress(&info, TRUE);
    for (int y = 0; y < image.rows; ++y) {
      auto* row = const_cast<JSAMPROW>(image.ptr(y));
      jpeg_write_scanlines(&info, &row, 1);
    }
    jpeg_finish_compress(&info);
    bytes.assign(buffer, buffer + size);
  }
  jpeg_destroy_compress(&info);
  std::free(buffer);  // NOLINT: libjpeg's allocation
  return done;
}

struct PngReader {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, leave, pass_over);
  png_infop info = png_create_info_struct(png);
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

void take(png_structp png, png_bytep data, png_size_t size) {
  auto& left = *static_cast<std::string_view*>(png_get_io_ptr(png));
  if (left.size() < size) png_error(png, "ends early");
  std::memcpy(data, left.data(), size);
  left.remove_prefix(size);
}

cv::Mat decode_png(std::string_view bytes, DecodedAs form) {
  PngReader reader;
  cv::Mat image;
  std::vector<png_bytep> rows;
  if (setjmp(png_jmpbuf(reader.png))) return {};  // NOLINT: libpng's way of failing
  png_set_read_fn(reader.png, &bytes, take);
  png_read_info(reader.png, reader.info);
  if (std::size_t{png_get_image_width(reader.png, reader.info)} *
          png_get_image_height(reader.png, reader.info) >
      most_pixels)
    return {};
  const int colour = png_get_color_type(reader.png, reader.info);
  const bool deep = form == DecodedAs::stored && png_get_bit_depth(reader.png, reader.info) == 16;
  const bool grey_file = (colour & PNG_COLOR_MASK_COLOR) == 0;
  const bool grey = form == DecodedAs::grey || (form == DecodedAs::stored && grey_file);
  if (deep) png_set_swap(reader.png);
  if (!deep) png_set_strip_16(reader.png);
  png_set_strip_alpha(reader.png);
  if (colour == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(reader.png);
  if (grey_file) png_set_expand_gray_1_2_4_to_8(reader.png);
  if (grey && !grey_file) png_set_rgb_to_gray(reader.png, 1, 0.299, 0.587);
  if (!grey && grey_file) png_set_gray_to_rgb(reader.png);
  if (!grey) png_set_bgr(reader.png);
  png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  image.create(static_cast<int>(png_get_image_height(reader.png, reader.info)),
               static_cast<int>(png_get_image_width(reader.png, reader.info)),
               CV_MAKETYPE(deep ? CV_16U : CV_8U, grey ? 1 : 3));
  rows.resize(static_cast<std::size_t>(image.rows));
  for (int y = 0; y < image.rows; ++y) rows[static_cast<std::size_t>(y)] = image.ptr(y);
  png_read_image(reader.png, rows.data());
  png_read_end(reader.png, nullptr);
  return image;
}

/// Exif's orientation, 1 to 8; 1 is upright, also where the file has none.
int orientation(const jpeg_decompress_struct& info) {
  for (jpeg_saved_marker_ptr m = info.marker_list; m != nullptr; m = m->next) {
    const std::string_view data(reinterpret_cast<const char*>(m->data), m->data_length);
    if (m->marker != JPEG_APP0 + 1 || data.size() < 14 || !data.starts_with(std::string_view("Exif\0\0", 6)))
      continue;
    const std::string_view tiff = data.substr(6);
    const bool little = tiff[0] == 'I';
    const auto number = [&](std::size_t at, std::size_t count) {
      std::size_t value = 0;
      for (std::size_t i = 0; at + count <= tiff.size() && i < count; ++i)
        value |= static_cast<std::size_t>(static_cast<unsigned char>(tiff[at + i]))
                 << 8U * (little ? i : count - 1 - i);
      return value;
    };
    constexpr std::size_t entry_bytes = 12;
    constexpr std::size_t orientation_tag = 0x0112;
    const std::size_t begin = number(4, 4);
    const std::size_t entries = number(begin, 2);
    for (std::size_t i = 0; i < entries && begin + 2 + (i + 1) * entry_bytes <= tiff.size(); ++i) {
      const std::size_t entry = begin + 2 + i * entry_bytes;
      if (number(entry, 2) == orientation_tag) return static_cast<int>(number(entry + 8, 2));
    }
  }
  return 1;
}

cv::Mat upright(cv::Mat image, int orientation) {
  if (orientation >= 5 && orientation <= 8) cv::transpose(image, image);
  const bool mirrored = orientation == 2 || orientation == 6;
  const bool upside_down = orientation == 4 || orientation == 8;
  if (orientation == 3 || orientation == 7) {
    cv::flip(image, image, -1);
  } else if (mirrored || upside_down) {
    cv::flip(image, image, mirrored ? 1 : 0);
  }
  return image;
}

struct JpegReader {
  JpegReader() {
    info.err = jpeg_errors(error);
    jpeg_create_decompress(&info);
  }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
  ~JpegReader() { jpeg_destroy_decompress(&info); }

  JpegError error;
  jpeg_decompress_struct info{};
};

std::optional<cv::Mat> decode_jpeg(std::string_view bytes, DecodedAs form) {
  JpegReader reader;
  jpeg_decompress_struct& info = reader.info;
  cv::Mat image;
  int turned = 1;
  if (setjmp(reader.error.place)) return cv::Mat();  // NOLINT: libjpeg's way of failing
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_save_markers(&info, JPEG_APP0 + 1, 0xffff);
  jpeg_read_header(&info, TRUE);
  if (info.num_components == 4) return std::nullopt;
  if (std::size_t{info.image_width} * info.image_height > most_pixels) return cv::Mat();
  turned = orientation(info);
  const bool grey = form == DecodedAs::grey || (form == DecodedAs::stored && info.num_components == 1);
  info.out_color_space = grey ? JCS_GRAYSCALE : JCS_EXT_BGR;
  jpeg_start_decompress(&info);
  image.create(static_cast<int>(info.output_height), static_cast<int>(info.output_width),
               grey ? CV_8UC1 : CV_8UC3);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = image.ptr(static_cast<int>(info.output_scanline));
    jpeg_read_scanlines(&info, &row, 1);
  }
  jpeg_finish_decompress(&info);
  return info.err->num_warnings == 0 ? upright(image, turned) : cv::Mat();
}

}  // namespace

std::vector<unsigned char> encoded_png_or_jpeg(std::string_view format, const cv::Mat& image, PngSize png) {
  Bytes bytes;
  if (!(format == "jpeg" ? encode_jpeg(image, bytes) : encode_png(image, png, bytes))) bytes.clear();
  return bytes;
}

std::optional<cv::Mat> decoded_png_or_jpeg(std::string_view bytes, DecodedAs form) {
  if (bytes.starts_with("\x89PNG")) return decode_png(bytes, form);
  if (bytes.starts_with("\xff\xd8")) return decode_jpeg(bytes, form);
  return std::nullopt;
}

}  // namespace saccade
