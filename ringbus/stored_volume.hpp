// Where the values of a volume lie, out of a message.
#pragma once

#include "message_generated.h"
#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::bus {

inline StoredVolume stored_volume_of(const schema::StoredVolume& wire) {
    StoredVolume stored{wire.component(), wire.big_endian(), wire.bits_stored(), {}};
    for (const schema::SlicesFile* file : *wire.files()) {
        stored.files.push_back({file->path()->str(),
                                file->offset(),
                                file->slices(),
                                {file->slope(), file->intercept()},
                                {file->size_bytes(), file->inode(), file->modified_ns()}});
    }
    return stored;
}

}  // namespace pxpl5::bus
