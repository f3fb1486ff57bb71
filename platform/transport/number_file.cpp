#include "transport/number_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>

#include "base/crc.hpp"
#include "errors.hpp"
#include "os/linux/file_faults.hpp"
#include "os/linux/file_lock.hpp"
#include "os/linux/file_owner.hpp"

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

/// Identifies a key without disclosing it: a MAC of a fixed text.
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

Descriptor open_numbers(const std::filesystem::path& file) {
  Descriptor opened(::open(
      file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, S_IRUSR | S_IWUSR));
  if (opened.get() < 0) {
    fail_to_open(file, file.string() + ": cannot be written", errno);
  }
  return opened;
}

}  // namespace

NumberFile::NumberFile(const std::filesystem::path& file,
                       const polhode_key& key,
                       std::uint64_t utc_ns,
                       WriteAt write)
    : write_(write), file_(open_numbers(file)), key_name_(name_of(key)) {
  const std::string problem = problem_of_owner(file_.get(), S_IWGRP | S_IWOTH);
  if (!problem.empty()) {
    throw UnusableInput(fmt::format("{}: {}", file.string(), problem));
  }
  lock_file(file_.get(), file.string());
  begin(file, utc_ns);
  // Both places: from here on the file never grows, so a full disk does not stop it.
  if (!put(number_) || !put(number_)) {
    fail_at_start(file.string() + ": cannot be written", errno);
  }
  wanted_ = done_ = written_ = number_;
  thread_.start(&NumberFile::work, this);
}

NumberFile::~NumberFile() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void NumberFile::begin(const std::filesystem::path& file, std::uint64_t utc_ns) {
  std::array<Place, 2 * kKeys> places;
  const ssize_t octets = ::pread(file_.get(), places.data(), sizeof places, 0);
  if (octets < 0) {
    fail_at_start(file.string() + ": cannot be read", errno);
  }
  constexpr std::size_t kPairOctets = 2 * sizeof(Place);
  const std::size_t pairs = (static_cast<std::size_t>(octets) + kPairOctets - 1) / kPairOctets;
  const std::size_t held = static_cast<std::size_t>(octets) / sizeof(Place);
  std::optional<std::size_t> own;
  bool torn = false;  // one of this key's places
  bool lost = false;  // a pair whose key is unknown
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    std::size_t mine = 0;
    std::size_t others = 0;
    for (std::size_t i = 2 * pair; i < std::min(held, 2 * pair + 2); ++i) {
      const bool is_mine = places[i].whole() && places[i].key_name == key_name_;
      mine += is_mine ? 1 : 0;
      others += places[i].whole() && !is_mine ? 1 : 0;
      number_ = is_mine ? std::max(number_, places[i].number) : number_;
    }
    own = mine > 0 && others == 0 ? pair : own;
    torn = torn || mine == 1;
    lost = lost || mine + others == 0;
  }
  pair_ = own.value_or(pairs);
  if (pair_ == kKeys) {
    throw UnusableInput(
        fmt::format("{}: holds the numbers of {} other keys, and has no room for "
                    "more: name a new file",
                    file.string(),
                    kKeys));
  }
  if (torn || (!own && (lost || pairs == 0))) {
    number_ = std::max(number_, utc_ns);
    remark_ = pairs == 0 ? "no numbers were kept: they begin at the present time"
                         : "numbers that were kept are damaged: they begin at the present time";
  } else if (!own) {
    remark_ = "a new key: numbers begin at 0";
  }
}

bool NumberFile::put(std::uint64_t number) {
  Place place;
  place.key_name = key_name_;
  place.number = number;
  place.crc32 = place.sum();
  const auto at = static_cast<off_t>((2 * pair_ + next_) * sizeof place);
  const ssize_t written = write_(file_.get(), &place, sizeof place, at);
  if (written != sizeof place) {
    errno = written < 0 ? errno : ENOSPC;  // a part of it: the call itself leaves an old error
    return false;
  }
  // Begins the writing and returns; without it the disk has it within half a minute.
  (void)::sync_file_range(file_.get(), at, sizeof place, SYNC_FILE_RANGE_WRITE);
  next_ = 1 - next_;
  return true;
}

Kept NumberFile::keep(std::uint64_t number) {
  std::unique_lock lock(mutex_);
  const bool late = done_ < wanted_;
  wanted_ = std::max(wanted_, number);
  changed_.notify_all();
  if (!late) {
    (void)changed_.wait_for(lock, kWait, [&] { return done_ >= number; });
  }
  return state_with_lock(number);
}

Kept NumberFile::state_of(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  return state_with_lock(number);
}

Kept NumberFile::state_with_lock(std::uint64_t number) const {
  if (written_ >= number) {
    return Kept::kYes;
  }
  return done_ >= number ? Kept::kRefused : Kept::kLate;
}

void NumberFile::work(void* numbers) { static_cast<NumberFile*>(numbers)->serve(); }

void NumberFile::serve() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || done_ < wanted_; });
    if (done_ == wanted_) {
      return;
    }
    const std::uint64_t number = wanted_;
    lock.unlock();
    const bool put_down = put(number);
    lock.lock();
    done_ = number;
    written_ = put_down ? number : written_;
    changed_.notify_all();
  }
}

}  // namespace polhode::platform
