#include "recording/decompressor.h"

#include <lz4frame.h>
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

}  // namespace

std::unique_ptr<Decompressor> make_copier() { return std::make_unique<Copier>(); }
std::unique_ptr<Decompressor> make_lz4_decompressor() { return std::make_unique<Lz4Decompressor>(); }
std::unique_ptr<Decompressor> make_zstd_decompressor() { return std::make_unique<ZstdDecompressor>(); }

}  // namespace saccade
