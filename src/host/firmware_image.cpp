#include <ano/wire.hpp>
#include <host/firmware_image.hpp>
#include <host/task.hpp>

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>
#include <utility>

namespace ano::host {
namespace {

using namespace std::string_view_literals;

// Positions of the fields in the header of a .bia; all other bytes of the header are 0.
constexpr std::string_view magic = "bia";
constexpr std::size_t version_at = 10, crc_at = 12, hw_type_at = 20, hw_ver_min_at = 30, hw_ver_max_at = 32, cmd_at = 50;

constexpr std::size_t piece = 16 * 1024;    // bytes read at a time

using Header = std::array<std::uint8_t, FirmwareImage::header_bytes>;

bool begins_with_magic(const Header& header) noexcept { return std::equal(magic.begin(), magic.end(), header.begin()); }

FirmwareImage with_header(const Header& header, FirmwareBytes bytes) {
    const std::uint8_t* at = header.data();
    return {std::move(bytes),
            load<std::uint16_t>(at + version_at),
            load<std::uint16_t>(at + crc_at),
            at[hw_type_at],
            load<std::uint16_t>(at + hw_ver_min_at),
            load<std::uint16_t>(at + hw_ver_max_at),
            load<std::uint32_t>(at + cmd_at),
            true};
}

std::optional<std::uint16_t> crc_in_pieces(const FirmwareBytes& file, const Crc16& crc) {
    Crc16Sum sum{crc};
    std::vector<std::uint8_t> room(std::min(piece, file.size()));
    for (std::size_t at = 0; at < file.size(); at += room.size()) {
        room.resize(std::min(room.size(), file.size() - at));
        if (!file.read(at, room)) return std::nullopt;
        sum.add(room);
    }
    return sum.value();
}

FirmwareFile of_bia(const FirmwareBytes& file, const Header& header) {
    if (file.size() <= header.size()) return {std::nullopt, {"file_cut_off"}};
    FirmwareImage image = with_header(header, file.behind(header.size()));
    if (image.hw_ver_min > image.hw_ver_max) return {std::nullopt, {"file_damaged"}};
    return {std::move(image), {}};
}

}    // namespace

FirmwareBytes::FirmwareBytes(std::vector<std::uint8_t> bytes) : size_{bytes.size()} {
    read_ = [all = std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes))](std::size_t at,
                                                                                        std::span<std::uint8_t> into) {
        std::copy_n(all->begin() + static_cast<std::ptrdiff_t>(at), into.size(), into.begin());
        return true;
    };
}

FirmwareBytes FirmwareBytes::behind(std::size_t n) const {
    return {size_ - n, [n, read = read_](std::size_t at, std::span<std::uint8_t> into) { return read(n + at, into); }};
}

FirmwareFile read_firmware(const FirmwareBytes& file, const Crc16& crc) {
    if (file.empty()) return {std::nullopt, {"file_empty"}};
    if (file.size() > FirmwareImage::max_bytes) return {std::nullopt, {"file_too_large"}};
    FirmwareFile unreadable{std::nullopt, {"file_unreadable"}};
    Header header{};
    if (!file.read(0, std::span{header}.first(std::min(header.size(), file.size())))) return unreadable;
    if (begins_with_magic(header)) return of_bia(file, header);
    const auto sum = crc_in_pieces(file, crc);
    if (!sum) return unreadable;
    FirmwareImage image;
    image.bytes = file;
    image.crc = *sum;
    return {std::move(image), {}};
}

Fault FirmwareImage::misfit(const DeviceInfo& device) const {
    if (is_for_any_hardware()) return {};
    if (hw_type != device.dev_id) return {"other_hardware", hex_of(hw_type), hex_of(device.dev_id)};
    if (device.hw_ver >= hw_ver_min && device.hw_ver <= hw_ver_max) return {};
    return {"other_hardware_version", hw_ver_min, hw_ver_max, device.hw_ver};
}

namespace {

constexpr char erased = '\xFF';    // a byte of flash

bool is_hex_digit(char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); }

/// `text` without the UTF-8 byte order mark, and without empty lines (any line ends) and control characters before the text.
std::string_view without_mark(std::string_view text) {
    constexpr std::string_view mark = "\xEF\xBB\xBF";
    const auto skip_blank = [&] {
        const auto is_blank = [](char c) { return static_cast<unsigned char>(c) <= 0x20; };
        text.remove_prefix(static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_blank) - text.begin()));
    };
    skip_blank();
    if (text.starts_with(mark)) text.remove_prefix(mark.size());
    skip_blank();
    return text;
}

/// Whether the first `digits` characters are hexadecimal digits.
bool begins_with_digits(std::string_view text, std::size_t digits) {
    return text.size() >= digits && std::all_of(text.begin(), text.begin() + digits, is_hex_digit);
}

/// A record of Intel HEX: a colon, and at least five bytes.
bool begins_as_hex(std::string_view begin) { return begin.starts_with(':') && begins_with_digits(begin.substr(1), 10); }

/// A record of Motorola S-record: S, its type, and at least four bytes.
bool begins_as_s_record(std::string_view begin) {
    return begin.size() > 1 && begin[0] == 'S' && begin[1] >= '0' && begin[1] <= '9' && begins_with_digits(begin.substr(2), 8);
}

struct FileKind {
    std::string_view magic;    // the bytes of the file from `at` on
    std::string_view description;
    std::size_t at = 0;
};

constexpr std::array file_kinds{
    FileKind{"\x7F"
             "ELF",
             "this is an ELF file; convert it: arm-none-eabi-objcopy -O binary FILE.elf FILE.bin"},
    FileKind{"UF2\n", "this is a UF2 file; convert it: uf2conv.py FILE.uf2 --convert --output FILE.bin"},
    FileKind{"PK\3\4", "this is a ZIP file; unpack it first"},
    FileKind{"PK\5\6", "this is a ZIP file; unpack it first"},
    FileKind{"PK\7\x08", "this is a part of a split ZIP file; unpack it first"},
    FileKind{"\x1F\x8B\x08", "this is a gzip file; unpack it first: gunzip FILE.gz"},
    FileKind{"\xFD"
             "7zXZ",
             "this is an xz file; unpack it first: unxz FILE.xz"},
    FileKind{"\x28\xB5\x2F\xFD", "this is a zstd file; unpack it first: unzstd FILE.zst"},
    FileKind{"BZh", "this is a bzip2 file; unpack it first: bunzip2 FILE.bz2"},
    FileKind{"7z\xBC\xAF\x27\x1C", "this is a 7-Zip file; unpack it first"},
    FileKind{"Rar!\x1A\7", "this is a RAR file; unpack it first"},
    FileKind{"\x5D\0\0"sv, "this is an lzma file; unpack it first: unlzma FILE.lzma"},
    FileKind{"DfuSe", "this is a DfuSe file (.dfu); convert it: dfuse-pack.py --dump FILE.dfu"},
    FileKind{"MZ", "this is a Windows program (.exe)"},
    FileKind{"\xCF\xFA\xED\xFE", "this is a macOS program (Mach-O)"},
    FileKind{"\xCE\xFA\xED\xFE", "this is a macOS program (Mach-O)"},
    FileKind{"\xFE\xED\xFA\xCE", "this is a macOS program (Mach-O)"},
    FileKind{"\xFE\xED\xFA\xCF", "this is a macOS program (Mach-O)"},
    FileKind{"\xCA\xFE\xBA\xBE", "this is a program of another system (Mach-O or Java)"},
    FileKind{"\x89PNG", "this is a picture (PNG)"},
    FileKind{"\xFF\xD8\xFF", "this is a picture (JPEG)"},
    FileKind{"GIF8", "this is a picture (GIF)"},
    FileKind{"<!DOCTYPE", "this is a web page"},
    FileKind{"<!doctype", "this is a web page"},
    FileKind{"<html", "this is a web page"},
    FileKind{"<?xml", "this is an XML file"},
    FileKind{"%PDF-", "this is a PDF document"},
    FileKind{"ustar", "this is a tar file; unpack it first: tar -xf FILE.tar", 257},
};

// Whether c is a character of a text file: printable, or one that a terminal obeys (\b \t \n \v \f \r ESC). Bytes from 0x80 on
// may be UTF-8 or GBK, neither of which uses 0xFF.
bool is_printed(char c) {
    const auto byte = static_cast<unsigned char>(c);
    constexpr unsigned char space = 0x20, del = 0x7F;
    return (byte >= space && byte != del && c != erased) || (c >= '\b' && c <= '\r') || c == '\x1B';
}

/// A web form (multipart/form-data): a boundary, and the header of a part.
bool begins_as_form(std::string_view begin) {
    constexpr std::string_view header = "\r\ncontent-disposition:";
    if (!begin.starts_with("--")) return false;
    begin.remove_prefix(std::min(begin.find("\r\n"), begin.size()));
    std::string line{begin.substr(0, header.size())};
    std::transform(line.begin(), line.end(), line.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c; });
    return line == header;
}

/// Text in units of `size` bytes (UTF-16, UTF-32), with the low byte first or last: all units are characters, and without a byte
/// order mark all are ASCII.
bool is_wide_text(std::string_view begin, std::size_t size, bool low_first) {
    constexpr std::size_t min_units = 4;
    constexpr std::uint32_t mark = 0xFEFF, space = 0x20, del = 0x7F, no_character = 0xFFFE, last = 0x10FFFF;
    if (begin.size() < min_units * size) return false;
    const auto unit = [&](std::size_t at) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < size; ++i)
            value = value << 8 | static_cast<unsigned char>(begin[at + (low_first ? size - 1 - i : i)]);
        return value;
    };
    const bool is_marked = unit(0) == mark;
    for (std::size_t at = is_marked ? size : 0; at + size <= begin.size(); at += size) {
        const std::uint32_t c = unit(at);
        const bool is_character = c >= space ? c != del && (c & 0xFFFF) < no_character && c <= last
                                             : c == '\t' || c == '\n' || c == '\r' || c == '\f';
        if (!is_character || (!is_marked && c > del)) return false;
    }
    return true;
}

bool is_text(std::string_view begin) {
    if (std::all_of(begin.begin(), begin.end(), is_printed)) return true;
    for (const std::size_t size : {2u, 4u})
        for (const bool low_first : {true, false})
            if (is_wide_text(begin, size, low_first)) return true;
    return false;
}

/// The number of bytes from `at` on up to the first that `is_like` does not accept; std::nullopt: they can't be read.
template <class IsLike>
std::optional<std::size_t> length_of(const FirmwareBytes& file, std::size_t at, IsLike is_like) {
    std::vector<std::uint8_t> bytes(piece);
    for (std::size_t next = at; next < file.size(); next += bytes.size()) {
        bytes.resize(std::min(piece, file.size() - next));
        if (!file.read(next, bytes)) return std::nullopt;
        const auto other = std::find_if(bytes.begin(), bytes.end(),
                                        [&](std::uint8_t b) { return !is_like(static_cast<char>(b)); });
        if (other != bytes.end()) return next - at + static_cast<std::size_t>(other - bytes.begin());
    }
    return file.size() - at;
}

/// The number of bytes from `at` on that are `pad`; std::nullopt: they can't be read.
std::optional<std::size_t> padding(const FirmwareBytes& file, std::size_t at, char pad) {
    return length_of(file, at, [pad](char c) { return c == pad; });
}

/// Nothing but characters and zeros, and erased flash behind them. Not: only zeros.
bool is_text_with_zeros(const FirmwareBytes& file, std::string_view begin) {
    if (begin.find_first_not_of('\0') == std::string_view::npos) return false;
    const auto length = length_of(file, 0, [](char c) { return c == '\0' || is_printed(c); });
    return length && *length > 0 && padding(file, *length, erased) == file.size() - *length;
}

/// A text followed only by zeros or erased flash.
bool is_text_and_padding(const FirmwareBytes& file, std::string_view begin) {
    const char pad = begin.back();
    if (pad != '\0' && pad != erased) return false;
    const std::size_t last = begin.find_last_not_of(pad);
    return last != std::string_view::npos && is_text(begin.substr(0, last + 1)) &&
           padding(file, begin.size(), pad) == file.size() - begin.size();
}

/// The end of a ZIP file, perhaps with a comment. Such a file may begin with any bytes, as a self-extracting one does.
bool ends_as_zip(const FirmwareBytes& file) {
    constexpr std::string_view magic_of_end = "PK\5\6";
    constexpr std::size_t end_bytes = 22, comment_size_at = 20, longest_comment = 0xFFFF;
    std::vector<std::uint8_t> tail(std::min(file.size(), end_bytes + longest_comment));
    if (tail.size() <= end_bytes || !file.read(file.size() - tail.size(), tail)) return false;
    for (auto at = tail.begin();; ++at) {
        at = std::search(at, tail.end(), magic_of_end.begin(), magic_of_end.end());
        const auto left = static_cast<std::size_t>(tail.end() - at);
        if (left < end_bytes) return false;
        if (load<std::uint16_t>(&*at + comment_size_at) == left - end_bytes) return true;
    }
}

/// The file without the header of a .bia and without leading padding. An image has a few zeros there, but no magic of another
/// file type after them.
FirmwareBytes content_of(const FirmwareBytes& whole, char pad) {
    constexpr std::size_t min_padding = 4;    // fewer may be part of a text in UTF-32, or of a byte order mark
    const auto size = padding(whole, 0, pad);
    return size && *size >= min_padding && *size < whole.size() ? whole.behind(*size) : whole;
}

}    // namespace

std::string looks_unlike_firmware(const FirmwareBytes& whole) {
    constexpr std::size_t looked_at = 1024;
    Header header{};
    const bool has_header = whole.size() > header.size() && whole.read(0, header) && begins_with_magic(header);
    const FirmwareBytes body = has_header ? whole.behind(header.size()) : whole;
    if (!body.empty() && padding(body, 0, erased) == body.size()) return "this is erased flash: every byte is 0xFF";
    const FirmwareBytes file = content_of(content_of(body, '\0'), erased);
    std::vector<std::uint8_t> bytes(std::min(file.size(), looked_at));
    if (bytes.empty() || !file.read(0, bytes)) return {};    // reading the whole file will fail and report the error
    const std::string_view begin{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    const std::string_view text = without_mark(begin);
    const std::string converts = "; convert it: arm-none-eabi-objcopy ";
    if (begins_as_hex(text)) return "this is an Intel HEX file" + converts + "-I ihex -O binary FILE.hex FILE.bin";
    if (begins_as_s_record(text)) return "this is a Motorola S-record file" + converts + "-I srec -O binary FILE.s19 FILE.bin";
    for (const FileKind& kind : file_kinds)
        if (begin.substr(std::min(kind.at, begin.size())).starts_with(kind.magic)) return std::string{kind.description};
    if (ends_as_zip(file)) return "this is a ZIP file; unpack it first";
    if (begins_as_form(begin)) return "this is a form of a web page (multipart/form-data); send the file itself";
    if (is_text(begin)) return "this is a text file";
    if (is_text_and_padding(file, begin)) return "this is a text file with padding behind it";
    if (is_text_with_zeros(file, begin)) return "this is a text file with zeros in it";
    return {};
}

}    // namespace ano::host
