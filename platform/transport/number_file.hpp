// The greatest number of a command taken, kept over restarts: a command captured before one is not
// taken after it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "transport/client/c/signing/polhode_sign.h"
#include "transport/datagram/datagram.hpp"

namespace polhode::platform {

/// Two places in a small file, written in turn: a write that is torn leaves the other whole.
class NumberFile {
 public:
  /// Begins with what is in the file. It belongs to one key: of another one nothing was captured,
  /// so numbers begin at 0. A missing or damaged file does not tell what was taken: numbers then
  /// begin at the present, so that nothing signed before is.
  /// @throws UnusableInput: the file cannot be made or written, or is another program's.
  NumberFile(const std::filesystem::path& file, const polhode_key& key, std::uint64_t utc_ns);

  [[nodiscard]] std::uint64_t number() const { return number_; }
  /// Where it began; empty when the file told it.
  [[nodiscard]] const std::string& remark() const { return remark_; }

  /// In the file when it returns, whatever happens to the process; the disk has it soon after.
  /// Never waits for the disk. @return false when the system refused it.
  bool keep(std::uint64_t number);

 private:
  struct Place;
  void begin(std::uint64_t utc_ns);

  Descriptor file_;
  std::uint64_t key_name_ = 0;
  std::uint64_t number_ = 0;
  unsigned next_ = 0;  ///< place written next
  std::string remark_;
};

}  // namespace polhode::platform
