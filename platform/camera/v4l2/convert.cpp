#include "camera/v4l2/convert.hpp"

#include <cstring>

#include "base/assert.hpp"

namespace polhode::platform {
namespace {

bool is_deep(const PixelPacking& packing) {
  return packing.packing == Packing::kGray16 || packing.packing == Packing::kGroups;
}

}  // namespace

GrayConverter::GrayConverter(const OfferedFormat& format)
    : format_(format), packing_(*find_packing(format.fourcc)) {
  POLHODE_ASSERT(consistent(format), format.image_bytes);
  const auto pixels =
      static_cast<std::size_t>(format.width_px) * static_cast<std::size_t>(format.height_px);
  const bool widened = is_deep(packing_) && packing_.bits < 16;
  const bool as_it_is = packing_.packing == Packing::kGray8 || (is_deep(packing_) && !widened);
  if (!as_it_is) {
    image_.resize(widened ? 2 * pixels : pixels);
  }
  if (packing_.packing == Packing::kCompressed) {
    decoder_ = std::make_unique<JpegDecoder>(format.width_px, format.height_px);
  }
}

bool GrayConverter::convert(std::span<const std::uint8_t> buffer, ImageView* view) {
  *view = {.data = image_.data(),
           .width_px = format_.width_px,
           .height_px = format_.height_px,
           .stride_bytes = format_.width_px,
           .format = PixelFormat::kGray8};
  if (packing_.packing == Packing::kCompressed) {
    return decoder_->decode(buffer, image_.data());
  }
  const std::size_t row = row_bytes_of(packing_, format_.width_px);
  const auto rows = static_cast<std::size_t>(format_.height_px);
  if (buffer.size() < format_.row_bytes * (rows - 1) + row) {
    return false;
  }
  if (is_deep(packing_)) {
    view->format = PixelFormat::kGray16;
    view->stride_bytes *= 2;
  }
  if (image_.empty()) {
    view->data = buffer.data();
    view->stride_bytes = format_.row_bytes;
  } else {
    convert_rows(buffer.data());
  }
  return true;
}

void GrayConverter::convert_rows(const std::uint8_t* buffer) {
  const std::size_t row_bytes = image_.size() / static_cast<std::size_t>(format_.height_px);
  for (int row = 0; row < format_.height_px; ++row) {
    const std::uint8_t* from = buffer + static_cast<std::size_t>(row) * format_.row_bytes;
    std::uint8_t* to = image_.data() + static_cast<std::size_t>(row) * row_bytes;
    switch (packing_.packing) {
      case Packing::kGray16:
        widen_row(from, format_.width_px, packing_.bits, to);
        break;
      case Packing::kGroups:
        group_row(from, format_.width_px, packing_, to);
        break;
      case Packing::kLumaChroma:
        luma_row(from, format_.width_px, to);
        break;
      case Packing::kChromaLuma:
        luma_row(from + 1, format_.width_px, to);
        break;
      case Packing::kRgb:
        rgb_row(from, format_.width_px, 0, to);
        break;
      case Packing::kBgr:
        rgb_row(from, format_.width_px, 2, to);
        break;
      case Packing::kGray8:
      case Packing::kCompressed:
        break;  // never converted by rows
    }
  }
}

void widen_row(const std::uint8_t* from, int pixels, int bits, std::uint8_t* to) {
  for (int i = 0; i < pixels; ++i) {
    const auto low = static_cast<unsigned>(from[2 * i]);
    const auto high = static_cast<unsigned>(from[2 * i + 1]);
    const auto wide =
        static_cast<std::uint16_t>((low | high << 8U) << (16U - static_cast<unsigned>(bits)));
    std::memcpy(to + 2 * i, &wide, sizeof wide);
  }
}

void group_row(const std::uint8_t* from,
               int pixels,
               const PixelPacking& packing,
               std::uint8_t* to) {
  const auto low_bits = static_cast<unsigned>(packing.bits - 8);
  for (int i = 0; i < pixels; ++i) {
    const int place = i % packing.group_pixels;
    const std::uint8_t* group = from + i / packing.group_pixels * packing.group_bytes;
    unsigned lows = 0;
    for (int k = packing.group_bytes - 1; k >= packing.group_pixels; --k) {
      lows = lows << 8U | static_cast<unsigned>(group[k]);
    }
    const unsigned low = lows >> (low_bits * static_cast<unsigned>(place)) & ((1U << low_bits) - 1);
    const auto wide = static_cast<std::uint16_t>(static_cast<unsigned>(group[place]) << 8U |
                                                 low << (8U - low_bits));
    std::memcpy(to + 2 * i, &wide, sizeof wide);
  }
}

void luma_row(const std::uint8_t* from, int pixels, std::uint8_t* to) {
  for (int i = 0; i < pixels; ++i) {
    to[i] = from[2 * i];
  }
}

void rgb_row(const std::uint8_t* from, int pixels, int red, std::uint8_t* to) {
  // Weights in 1/65536, as for colour files.
  for (int i = 0; i < pixels; ++i) {
    const std::uint8_t* rgb = from + 3 * i;
    const std::uint32_t sum = 19595U * rgb[red] + 38470U * rgb[1] + 7471U * rgb[2 - red];
    to[i] = static_cast<std::uint8_t>((sum + 32768U) >> 16U);
  }
}

}  // namespace polhode::platform
