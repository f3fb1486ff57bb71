// What a component answers to commands, as it comes over the bus.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

struct polhode_bus;

namespace polhode::platform {

/// Listens from its making on, so that the answer to a command that is sent next is not missed.
/// Each command is answered by one event; those of other senders cannot be told from one's own.
class BusAnswers {
 public:
  /// @param address of telemetry, as `polhode bus follow` takes it.
  /// @throws UnusableInput: it cannot be opened.
  BusAnswers(const std::string& address, int apid_first);

  /// Prints each answer as it comes.
  /// @return commands refused, of `commands`.
  /// @throws RunFailure: no answer to one of them within the time.
  std::size_t wait(std::size_t commands, double timeout_s);

 private:
  struct Answer {
    std::size_t commands = 0;  ///< that it answers; 0: another packet
    bool refused = false;
  };
  [[nodiscard]] Answer read(std::span<const std::uint8_t> octets) const;

  struct Close {
    void operator()(polhode_bus* bus) const;
  };
  std::string address_;
  int apid_first_;
  std::unique_ptr<polhode_bus, Close> bus_;
};

}  // namespace polhode::platform
