#include "isa/table_hash.hpp"

namespace pxpl5::isa {

std::string_view table_hash() {
    return PXPL5_TABLE_HASH;
}

}  // namespace pxpl5::isa
