// Which slices a GP's trace need not hold, because the trace of another GP holds them.
#pragma once

#include "gp_firmware/volume/share.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::gp {

/// Follows what a GP receives. A slice goes to up to four GPs; the traces of all GPs together hold
/// it once: that of the owner of slab z holds slice z, the last slice excepted, which is with the
/// slice before it. A flight recorder whose set-up has no room for the GP's own slices would keep
/// some of them for a while: memory for nothing, and they are left out, too.
class CopiedSlices {
  public:
    /// Takes every message that the GP receives, in order, and tells of each whether it has only
    /// slices that other traces hold.
    bool operator()(const bus::Message& message);

  private:
    std::size_t own_bytes() const;

    Share share_;
    bool flight_ = false, too_large_ = false;
    VolumeShape shape_;  ///< Of the volume that is coming: slices and sets only.
};

}  // namespace pxpl5::gp
