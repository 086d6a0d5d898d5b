// Copied slices: the slices that a GP's trace omits because the trace of another GP has them.
#pragma once

#include "gp_firmware/volume/share.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::gp {

/// Follows the messages that a GP receives. A slice is sent to up to four GPs, but the traces of
/// all GPs together contain it once: the owner of slab z records slice z. The owner of the last
/// slab also records the last slice. A flight recorder whose set-up has no room for all of the GP's
/// own slices omits them, too, because some of them alone are useless.
class CopiedSlices {
  public:
    /// Takes every message that the GP receives, in order. Returns whether the trace omits it,
    /// because other traces have all of its slices.
    bool operator()(const bus::Message& message);

  private:
    std::size_t own_bytes() const;

    Share share_;
    bool flight_ = false, too_large_ = false;
    VolumeShape shape_;  ///< Shape of the announced volume; only dimensions, type and set size.
};

}  // namespace pxpl5::gp
