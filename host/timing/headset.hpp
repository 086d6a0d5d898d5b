// The modelled machine with a head-mounted display: pairs of pictures, and how late they are.
#pragma once

#include <span>
#include <string_view>

#include "host/timing/counts/machine.hpp"
#include "host/timing/counts/work.hpp"
#include "host/timing/simulate.hpp"

namespace pxpl5::host::timing {

/// Names, units, provenance and sources are in headset_rows().
struct Headset {
#define PXPL5_HEADSET(field, name, unit, value, provenance, source) double field = value;
#include "host/timing/headset.def"

    double field_ms() const {
        return 1000 / field_hz;
    }
    /// The time for which a complete picture waits for a field, on average.
    double wait_ms() const {
        return wait_fields * field_ms();
    }
    /// The time from the swap to the last line on the display.
    double scan_out_ms() const {
        return scan_out_fields * field_ms();
    }
};

struct HeadsetRow {
    std::string_view name;  ///< "tracker.least_ms"
    std::string_view unit;
    double Headset::*value;
    Provenance provenance;
    std::string_view source;
};

/// All numbers, in the order of the table.
std::span<const HeadsetRow> headset_rows();

/// The machine that draws for the display: with its frame buffers, which swap at its fields.
Machine headset_machine(const Machine& machine, const Headset& headset);

/// Pairs of pictures on headset_machine().
struct HeadsetTime {
    Rate rate;            ///< Rate of pairs.
    double drawn_ms = 0;  ///< From the command to the last pixel of both eyes.
    /// From the movement of the head to the last line of the first field of both pictures, with the
    /// least and the greatest delay of the tracker.
    double least_ms = 0, most_ms = 0;
};

/// pair  A frame of two views. Throws like simulate().
HeadsetTime headset_time(const Machine& machine, const Headset& headset, const FrameWork& pair);

}  // namespace pxpl5::host::timing
