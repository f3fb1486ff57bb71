#include "transport/number_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <span>
#include <string_view>
#include <system_error>

#include "base/crc.hpp"
#include "errors.hpp"
#include "os/linux/file_lock.hpp"

namespace polhode::platform {

/// As it lies in memory: read on the same machine only.
struct NumberFile::Place {
  std::array<char, 8> magic{'P', 'L', 'H', 'N', 'U', 'M', '0', '1'};
  std::uint64_t key_name = 0;
  std::uint64_t number = 0;
  std::uint32_t crc32 = 0;
  std::uint32_t spare = 0;

  [[nodiscard]] std::uint32_t sum() const {
    static_assert(sizeof(Place) == 32, "no gaps");
    return crc32_iso_hdlc({reinterpret_cast<const std::uint8_t*>(this), offsetof(Place, crc32)});
  }
  [[nodiscard]] bool whole() const { return magic == Place{}.magic && crc32 == sum(); }
};

namespace {

/// Tells keys apart and says nothing about them: a MAC of a fixed text.
std::uint64_t name_of(const polhode_key& key) {
  constexpr std::string_view kText = "polhode command numbers";
  std::array<std::uint8_t, POLHODE_MAC_OCTETS> mac{};
  std::uint64_t name = 0;
  if (polhode_mac(
          &key, reinterpret_cast<const std::uint8_t*>(kText.data()), kText.size(), mac.data()) !=
      0) {
    throw RunFailure("HMAC-SHA-256 is not available in libcrypto");
  }
  std::memcpy(&name, mac.data(), sizeof name);
  return name;
}

int open_numbers(const std::filesystem::path& file) {
  const int fd = ::open(
      file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, S_IRUSR | S_IWUSR);
  if (fd < 0) {
    throw UnusableInput(fmt::format(
        "{}: cannot be written: {}", file.string(), std::generic_category().message(errno)));
  }
  return fd;
}

}  // namespace

NumberFile::NumberFile(const std::filesystem::path& file,
                       const polhode_key& key,
                       std::uint64_t utc_ns)
    : file_(open_numbers(file)), key_name_(name_of(key)) {
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0 || !S_ISREG(status.st_mode) ||
      status.st_uid != ::geteuid() || (status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    throw UnusableInput(
        fmt::format("{}: is no file of this user's own, or others may write to it", file.string()));
  }
  const std::string taken = lock_file(file_.get());
  if (!taken.empty()) {
    throw UnusableInput(fmt::format("{}: {}", file.string(), taken));
  }
  begin(utc_ns);
  // Both places: from here on the file never grows, so a full disk does not stop it.
  if (!keep(number_) || !keep(number_)) {
    throw UnusableInput(fmt::format(
        "{}: cannot be written: {}", file.string(), std::generic_category().message(errno)));
  }
}

void NumberFile::begin(std::uint64_t utc_ns) {
  std::array<Place, 2> places;
  const ssize_t octets = ::pread(file_.get(), places.data(), sizeof places, 0);
  bool known = false;
  bool other_key = false;
  std::size_t whole = 0;
  for (std::size_t i = 0; octets == sizeof places && i < places.size(); ++i) {
    whole += places[i].whole() ? 1 : 0;
    if (places[i].whole() && places[i].key_name == key_name_) {
      known = true;
      number_ = std::max(number_, places[i].number);
    }
    other_key = other_key || places[i].whole();
  }
  if (known && whole < places.size()) {  // the greater number may have stood in the other
    number_ = std::max(number_, utc_ns);
    remark_ = "one of the numbers kept is damaged: they begin at the present time";
    return;
  }
  if (known || other_key) {
    remark_ = known ? "" : "a new key: numbers begin at 0";
    return;
  }
  number_ = utc_ns;
  remark_ = octets == 0 ? "no numbers were kept: they begin at the present time"
                        : "the numbers kept are damaged: they begin at the present time";
}

bool NumberFile::keep(std::uint64_t number) {
  Place place;
  place.key_name = key_name_;
  place.number = number;
  place.crc32 = place.sum();
  const auto at = static_cast<off_t>(next_ * sizeof place);
  if (::pwrite(file_.get(), &place, sizeof place, at) != sizeof place) {
    return false;
  }
  // Begins the writing and returns; without it the disk has it within half a minute.
  (void)::sync_file_range(file_.get(), at, sizeof place, SYNC_FILE_RANGE_WRITE);
  number_ = number;
  next_ = 1 - next_;
  return true;
}

}  // namespace polhode::platform
