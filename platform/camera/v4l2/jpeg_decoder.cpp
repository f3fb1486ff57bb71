// libjpeg takes its memory through a table of functions of the decoder; here they draw on one block
// that each image fills from its beginning.
#include "camera/v4l2/jpeg_decoder.hpp"

#include <cstdio>  // jpeglib.h needs FILE

#include <jpeglib.h>

#include <algorithm>
#include <csetjmp>
#include <vector>

#include "camera/jpeg_remarks.hpp"

namespace polhode::platform {
namespace {

// Vector units read and write whole lines beyond a row's end.
constexpr std::size_t kAlignment = 64;
// Huffman and quantisation tables, each slot of them once.
constexpr std::size_t kPermanentBytes = 32 * 1024;
// Tables and a group of rows of all components, before and after upsampling: under 200 bytes for
// each pixel of a row, whatever the subsampling (tests/platform/v4l2/jpeg_decoder_test.cpp).
constexpr std::size_t kImageBytes = 128 * 1024;
constexpr std::size_t kPerColumn = 256;

constexpr std::size_t rounded(std::size_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

/// Memory that is given out piece by piece, and taken back as a whole.
struct Arena {
  std::vector<std::byte> bytes;
  std::size_t begin = 0;  ///< of the aligned part
  std::size_t used = 0;
  std::size_t peak = 0;

  explicit Arena(std::size_t size) : bytes(size + kAlignment) {
    const auto at = reinterpret_cast<std::uintptr_t>(bytes.data());
    begin = rounded(at) - at;
  }
  void* take(std::size_t wanted) {
    if (wanted > bytes.size() || used + rounded(wanted) > bytes.size() - kAlignment) {
      return nullptr;
    }
    void* const piece = bytes.data() + begin + used;
    used += rounded(wanted);
    peak = std::max(peak, used);
    return piece;
  }
};

}  // namespace

struct JpegDecoder::State {
  jpeg_decompress_struct decoder{};
  jpeg_error_mgr errors{};
  jpeg_memory_mgr memory{};
  jpeg_memory_mgr* own_memory = nullptr;  ///< the library's, for its memory at creation
  std::jmp_buf failed{};
  const JOCTET* file = nullptr;  ///< that is being decoded
  Arena permanent{kPermanentBytes};
  Arena image;
  int width_px;
  int height_px;

  State(int width, int height)
      : image(kImageBytes + kPerColumn * static_cast<std::size_t>(width)),
        width_px(width),
        height_px(height) {}
};

namespace {

JpegDecoder::State* state_of(j_common_ptr decoder) {
  return static_cast<JpegDecoder::State*>(decoder->client_data);
}

[[noreturn]] void abort_decoding(j_common_ptr decoder) {
  std::longjmp(state_of(decoder)->failed, 1);
}

void warn(j_common_ptr decoder, int level) {
  const JpegDecoder::State* state = state_of(decoder);
  if (level < 0 && indicates_damage(state->decoder, state->file)) {
    abort_decoding(decoder);
  }
}

void emit_nothing(j_common_ptr /*decoder*/) {}

void* take(j_common_ptr decoder, int pool, std::size_t bytes) {
  JpegDecoder::State* state = state_of(decoder);
  Arena& arena = pool == JPOOL_PERMANENT ? state->permanent : state->image;
  void* const piece = arena.take(bytes);
  if (piece == nullptr) {
    abort_decoding(decoder);
  }
  return piece;
}

template <typename Row>
Row* take_rows(j_common_ptr decoder, int pool, std::size_t row_bytes, JDIMENSION rows) {
  auto* table = static_cast<Row*>(take(decoder, pool, rows * sizeof(Row)));
  const std::size_t pitch = rounded(row_bytes) + kAlignment;
  auto* bytes = static_cast<std::byte*>(take(decoder, pool, rows * pitch));
  for (JDIMENSION i = 0; i < rows; ++i) {
    table[i] = reinterpret_cast<Row>(bytes + i * pitch);
  }
  return table;
}

JSAMPARRAY take_samples(j_common_ptr decoder, int pool, JDIMENSION width, JDIMENSION rows) {
  return take_rows<JSAMPROW>(decoder, pool, width * sizeof(JSAMPLE), rows);
}

JBLOCKARRAY take_blocks(j_common_ptr decoder, int pool, JDIMENSION width, JDIMENSION rows) {
  return take_rows<JBLOCKROW>(decoder, pool, width * sizeof(JBLOCK), rows);
}

// A whole image of coefficients: progressive, or in several scans, which no camera sends.
jvirt_sarray_ptr no_samples(
    j_common_ptr decoder, int, boolean, JDIMENSION, JDIMENSION, JDIMENSION) {
  abort_decoding(decoder);
}
jvirt_barray_ptr no_blocks(j_common_ptr decoder, int, boolean, JDIMENSION, JDIMENSION, JDIMENSION) {
  abort_decoding(decoder);
}
JSAMPARRAY no_sample_rows(j_common_ptr decoder, jvirt_sarray_ptr, JDIMENSION, JDIMENSION, boolean) {
  abort_decoding(decoder);
}
JBLOCKARRAY no_block_rows(j_common_ptr decoder, jvirt_barray_ptr, JDIMENSION, JDIMENSION, boolean) {
  abort_decoding(decoder);
}
void nothing_to_realize(j_common_ptr /*decoder*/) {}

void take_back(j_common_ptr decoder, int pool) {
  if (pool == JPOOL_IMAGE) {
    state_of(decoder)->image.used = 0;
  }
}

jpeg_memory_mgr own_functions(const jpeg_memory_mgr& library) {
  jpeg_memory_mgr memory = library;
  memory.alloc_small = take;
  memory.alloc_large = take;
  memory.alloc_sarray = take_samples;
  memory.alloc_barray = take_blocks;
  memory.request_virt_sarray = no_samples;
  memory.request_virt_barray = no_blocks;
  memory.realize_virt_arrays = nothing_to_realize;
  memory.access_virt_sarray = no_sample_rows;
  memory.access_virt_barray = no_block_rows;
  memory.free_pool = take_back;
  memory.self_destruct = emit_nothing;
  return memory;
}

}  // namespace

JpegDecoder::JpegDecoder(int width_px, int height_px)
    : state_(std::make_unique<State>(width_px, height_px)) {
  State& s = *state_;
  s.decoder.err = jpeg_std_error(&s.errors);
  s.errors.error_exit = abort_decoding;
  s.errors.emit_message = warn;
  s.errors.output_message = emit_nothing;
  s.decoder.client_data = &s;
  jpeg_create_decompress(&s.decoder);
  s.own_memory = s.decoder.mem;
  s.memory = own_functions(*s.own_memory);
  s.decoder.mem = &s.memory;
}

JpegDecoder::~JpegDecoder() {
  state_->decoder.mem = state_->own_memory;
  jpeg_destroy_decompress(&state_->decoder);
}

bool JpegDecoder::decode(std::span<const std::uint8_t> bytes, std::uint8_t* gray) {
  State* const s = state_.get();
  if (bytes.empty()) {
    return false;
  }
  if (setjmp(s->failed) != 0) {  // NOLINT(cert-err52-cpp): the library's way out of an error
    jpeg_abort_decompress(&s->decoder);
    return false;
  }
  s->file = bytes.data();
  jpeg_mem_src(&s->decoder, bytes.data(), static_cast<unsigned long>(bytes.size()));
  (void)jpeg_read_header(&s->decoder, TRUE);
  if (s->decoder.image_width != static_cast<JDIMENSION>(s->width_px) ||
      s->decoder.image_height != static_cast<JDIMENSION>(s->height_px)) {
    jpeg_abort_decompress(&s->decoder);
    return false;
  }
  s->decoder.out_color_space = JCS_GRAYSCALE;
  s->decoder.dct_method = JDCT_ISLOW;  // the same pixels whatever vector unit the machine has
  (void)jpeg_start_decompress(&s->decoder);
  while (s->decoder.output_scanline < s->decoder.output_height) {
    JSAMPROW row = gray + static_cast<std::size_t>(s->decoder.output_scanline) *
                              static_cast<std::size_t>(s->width_px);
    (void)jpeg_read_scanlines(&s->decoder, &row, 1);
  }
  (void)jpeg_finish_decompress(&s->decoder);
  return true;
}

std::size_t JpegDecoder::peak_bytes() const { return state_->image.peak; }
std::size_t JpegDecoder::memory_bytes() const { return state_->image.bytes.size(); }

}  // namespace polhode::platform
