#include "recording/decompressor.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>

#include "core/error.h"

namespace saccade {
namespace {

class Copier final : public Decompressor {
 public:
  void begin() override {}
  Step run(std::string_view in, std::span<char> out) override {
    const std::size_t count = std::min(in.size(), out.size());
    std::copy_n(in.begin(), count, out.begin());
    return {count, count, nullptr};
  }
  bool unfinished() const override { return false; }
};

class Lz4Decompressor final : public Decompressor {
 public:
  Lz4Decompressor() {
    LZ4F_dctx* context = nullptr;
    SACCADE_CHECK(LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) == 0);
    context_.reset(context);
  }

  void begin() override {
    LZ4F_resetDecompressionContext(context_.get());
    unfinished_ = true;
  }

  Step run(std::string_view in, std::span<char> out) override {
    Step step{in.size(), out.size(), nullptr};
    const std::size_t result =
        LZ4F_decompress(context_.get(), out.data(), &step.written, in.data(), &step.read, nullptr);
    if (LZ4F_isError(result) != 0) return {0, 0, LZ4F_getErrorName(result)};
    unfinished_ = result != 0;
    return step;
  }

  bool unfinished() const override { return unfinished_; }

 private:
  struct Free {
    void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
  };
  std::unique_ptr<LZ4F_dctx, Free> context_;
  bool unfinished_ = false;
};

class ZstdDecompressor final : public Decompressor {
 public:
  ZstdDecompressor() : context_(ZSTD_createDCtx()) { SACCADE_CHECK(context_ != nullptr); }

  void begin() override {
    ZSTD_DCtx_reset(context_.get(), ZSTD_reset_session_only);
    unfinished_ = true;
  }

  Step run(std::string_view in, std::span<char> out) override {
    ZSTD_inBuffer from{in.data(), in.size(), 0};
    ZSTD_outBuffer to{out.data(), out.size(), 0};
    const std::size_t result = ZSTD_decompressStream(context_.get(), &to, &from);
    if (ZSTD_isError(result) != 0) return {0, 0, ZSTD_getErrorName(result)};
    unfinished_ = result != 0;
    return {from.pos, to.pos, nullptr};
  }

  bool unfinished() const override { return unfinished_; }

 private:
  struct Free {
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
  };
  std::unique_ptr<ZSTD_DCtx, Free> context_;
  bool unfinished_ = false;
};

class Bzip2Decompressor final : public Decompressor {
 public:
  Bzip2Decompressor() = default;
  ~Bzip2Decompressor() override { BZ2_bzDecompressEnd(&stream_); }
  Bzip2Decompressor(const Bzip2Decompressor&) = delete;
  Bzip2Decompressor& operator=(const Bzip2Decompressor&) = delete;

  void begin() override {
    BZ2_bzDecompressEnd(&stream_);
    stream_ = {};
    SACCADE_CHECK(BZ2_bzDecompressInit(&stream_, 0, 0) == BZ_OK);
    unfinished_ = true;
  }

  Step run(std::string_view in, std::span<char> out) override {
    if (!unfinished_) begin();
    stream_.next_in = const_cast<char*>(in.data());  // bzlib does not change it
    stream_.avail_in = static_cast<unsigned>(in.size());
    stream_.next_out = out.data();
    stream_.avail_out = static_cast<unsigned>(out.size());
    const int result = BZ2_bzDecompress(&stream_);
    if (result != BZ_OK && result != BZ_STREAM_END) return {0, 0, "broken bzip2 data"};
    unfinished_ = result == BZ_OK;
    return {in.size() - stream_.avail_in, out.size() - stream_.avail_out, nullptr};
  }

  bool unfinished() const override { return unfinished_; }

 private:
  bz_stream stream_{};
  bool unfinished_ = false;
};

class DeflateDecompressor final : public Decompressor {
 public:
  DeflateDecompressor() { SACCADE_CHECK(inflateInit2(&stream_, -MAX_WBITS) == Z_OK); }
  ~DeflateDecompressor() override { inflateEnd(&stream_); }
  DeflateDecompressor(const DeflateDecompressor&) = delete;
  DeflateDecompressor& operator=(const DeflateDecompressor&) = delete;

  void begin() override {
    inflateReset(&stream_);
    unfinished_ = true;
  }

  Step run(std::string_view in, std::span<char> out) override {
    if (!unfinished_) return {0, 0, "bytes after the end of deflated data"};
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(in.data()));  // zlib does not change it
    stream_.avail_in = static_cast<uInt>(in.size());
    stream_.next_out = reinterpret_cast<Bytef*>(out.data());
    stream_.avail_out = static_cast<uInt>(out.size());
    const int result = inflate(&stream_, Z_NO_FLUSH);
    if (result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR)
      return {0, 0, "broken deflated data"};
    unfinished_ = result != Z_STREAM_END;
    return {in.size() - stream_.avail_in, out.size() - stream_.avail_out, nullptr};
  }

  bool unfinished() const override { return unfinished_; }

 private:
  z_stream stream_{};
  bool unfinished_ = false;
};

}  // namespace

std::unique_ptr<Decompressor> make_bzip2_decompressor() { return std::make_unique<Bzip2Decompressor>(); }
std::unique_ptr<Decompressor> make_deflate_decompressor() { return std::make_unique<DeflateDecompressor>(); }
std::unique_ptr<Decompressor> make_copier() { return std::make_unique<Copier>(); }
std::unique_ptr<Decompressor> make_lz4_decompressor() { return std::make_unique<Lz4Decompressor>(); }
std::unique_ptr<Decompressor> make_zstd_decompressor() { return std::make_unique<ZstdDecompressor>(); }

}  // namespace saccade
