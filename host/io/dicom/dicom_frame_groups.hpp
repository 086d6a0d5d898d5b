// Where the elements of one frame of a DICOM file are. Only files that include GDCM include this.
#pragma once

#include <gdcmDataSet.h>
#include <gdcmSequenceOfItems.h>

#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/io/dicom/dicom_elements.hpp"

namespace pxpl5::host::io {

/// The data sets in which a frame's element may be: the frame's own functional group, the shared
/// one, the file's.
class FrameGroups {
  public:
    FrameGroups(const gdcm::DataSet& file, int frame) : file_(&file) {
        add_group(gdcm::Tag(0x5200, 0x9230), static_cast<std::size_t>(frame) + 1);
        add_group(gdcm::Tag(0x5200, 0x9229), 1);
    }

    /// The first of: element `tag` in sequence `macro` of the groups, `tag` in the file.
    std::vector<double> numbers(const std::string& name, gdcm::Tag macro, gdcm::Tag tag) const {
        for (const gdcm::SmartPointer<gdcm::SequenceOfItems>& group : groups_of(macro)) {
            const auto found = numbers_of(name, group->GetItem(1).GetNestedDataSet(), tag);
            if (!found.empty()) {
                return found;
            }
        }
        return numbers_of(name, *file_, tag);
    }

    /// The same as numbers(), but as text.
    std::string text(gdcm::Tag macro, gdcm::Tag tag) const {
        for (const gdcm::SmartPointer<gdcm::SequenceOfItems>& group : groups_of(macro)) {
            std::string found = text_of(group->GetItem(1).GetNestedDataSet(), tag);
            if (!found.empty()) {
                return found;
            }
        }
        return text_of(*file_, tag);
    }

    /// The bytes of an element, found as by numbers().
    std::string bytes(gdcm::Tag macro, gdcm::Tag tag) const {
        for (const gdcm::SmartPointer<gdcm::SequenceOfItems>& group : groups_of(macro)) {
            std::string found = bytes_of(group->GetItem(1).GetNestedDataSet(), tag);
            if (!found.empty()) {
                return found;
            }
        }
        return bytes_of(*file_, tag);
    }

    /// A binary number (US, UL or FD). No value if it is absent or of another size.
    template <typename T>
    std::optional<T> binary(gdcm::Tag macro, gdcm::Tag tag) const {
        const std::string found = bytes(macro, tag);
        T value{};
        if (found.size() != sizeof value) {
            return std::nullopt;
        }
        std::memcpy(&value, found.data(), sizeof value);
        return value;
    }

    bool has(gdcm::Tag macro) const { return !groups_of(macro).empty(); }

  private:
    using Items = gdcm::SmartPointer<gdcm::SequenceOfItems>;

    void add_group(gdcm::Tag tag, std::size_t item) {
        if (!file_->FindDataElement(tag)) {
            return;
        }
        const Items items = file_->GetDataElement(tag).GetValueAsSQ();
        if (items != nullptr && items->GetNumberOfItems() >= item) {
            groups_.push_back({items, item});
        }
    }

    std::vector<Items> groups_of(gdcm::Tag macro) const {
        std::vector<Items> found;
        for (const auto& [items, item] : groups_) {
            const gdcm::DataSet& group = items->GetItem(item).GetNestedDataSet();
            if (group.FindDataElement(macro)) {
                const Items inner = group.GetDataElement(macro).GetValueAsSQ();
                if (inner != nullptr && inner->GetNumberOfItems() > 0) {
                    found.push_back(inner);
                }
            }
        }
        return found;
    }

    const gdcm::DataSet* file_;
    std::vector<std::pair<Items, std::size_t>> groups_;
};

/// Reads the elements that tell a frame from others of its place. Elements that make no sense count
/// as absent.
DicomTimes read_times(const gdcm::DataSet& data, const FrameGroups& groups);

}  // namespace pxpl5::host::io
