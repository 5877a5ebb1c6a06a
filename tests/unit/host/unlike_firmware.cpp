// Files that are not firmware images: each is recognized by its first bytes, with the way to convert it.
#include <host/firmware_image.hpp>

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace ano::host::unlike_firmware_tests {
namespace {

std::string doubt_about(std::string_view file) {
    return looks_unlike_firmware(std::vector<std::uint8_t>{file.begin(), file.end()});
}

void expect_doubt(std::string_view file, std::string_view kind, std::string_view remedy) {
    const std::string doubt = doubt_about(file);
    EXPECT_NE(doubt.find(kind), std::string::npos) << kind << ": '" << doubt << '\'';
    EXPECT_NE(doubt.find(remedy), std::string::npos) << kind << ": '" << doubt << '\'';
}

// Adds content like that of a compiled image after the first bytes.
std::string with_bytes(std::string_view begin) {
    std::string file{begin};
    for (std::size_t i = 0; i < 3000; ++i) file += static_cast<char>(i * 37 + i / 256);
    return file;
}

TEST(UnlikeFirmware, is_an_archive_or_another_packed_format) {
    expect_doubt(with_bytes({"UF2\nWQ]\x9E", 8}), "UF2", "uf2conv.py FILE.uf2 --convert --output FILE.bin");
    expect_doubt(with_bytes({"\x1F\x8B\x08\0", 4}), "gzip", "gunzip FILE.gz");
    expect_doubt(with_bytes({"\xFD"
                             "7zXZ\0",
                             6}),
                 "xz", "unxz FILE.xz");
    expect_doubt(with_bytes("\x28\xB5\x2F\xFD"), "zstd", "unzstd FILE.zst");
    expect_doubt(with_bytes("BZh9"), "bzip2", "bunzip2 FILE.bz2");
    expect_doubt(with_bytes("7z\xBC\xAF\x27\x1C"), "7-Zip", "unpack");
    expect_doubt(with_bytes("Rar!\x1A\x07"), "RAR", "unpack");
    expect_doubt(with_bytes("PK\x03\x04"), "ZIP", "unpack");
    expect_doubt(with_bytes("PK\x07\x08"), "split ZIP", "unpack");
    expect_doubt(with_bytes("readme.txt" + std::string(247, '\0') + "ustar"), "tar", "tar -xf FILE.tar");
    expect_doubt(with_bytes("%PDF-1.7\n%\xE2\xE3\xCF\xD3\n"), "PDF", "");
}

TEST(UnlikeFirmware, is_intel_hex_with_any_line_ending) {
    const std::string record = ":10010000214601360121470136007EFE09D2190140", end = ":00000001FF";
    for (const std::string line_end : {"\n", "\r\n", "\r", "\n\r", "\v", "\f", "\x1A"})
        for (const std::string& file : {record + line_end + end + line_end, line_end + record + line_end + end,
                                        line_end + line_end + "\xEF\xBB\xBF" + record, "\xEF\xBB\xBF" + line_end + record})
            expect_doubt(file, "Intel HEX", "objcopy -I ihex -O binary FILE.hex FILE.bin");
    const std::string zero(1, '\0');
    expect_doubt(zero + record + zero + end + zero, "Intel HEX", "objcopy -I ihex");
    expect_doubt(end, "Intel HEX", "objcopy -I ihex");
}

TEST(UnlikeFirmware, is_a_motorola_s_record_with_any_line_ending) {
    for (const std::string line_end : {"\n", "\r\n", "\r"})
        for (const std::string record : {"S00F000068656C6C6F202020202000003C", "S1137AF00A0A0D0000000000000000000000000061",
                                         "S2100000007C0802A6900100049421FFF0B6", "S31500000000215A1A6B00000000000000000000000009",
                                         "S5030003F9", "S9030000FC"})
            expect_doubt(line_end + record + line_end + "S9030000FC" + line_end, "Motorola S-record",
                         "objcopy -I srec -O binary FILE.s19 FILE.bin");
}

TEST(UnlikeFirmware, is_a_text_followed_by_zeros_but_not_an_image_that_starts_with_a_text) {
    const std::string zeros(40000, '\0');
    expect_doubt("a readme\n" + zeros, "text", "");
    for (const std::size_t at : {2000u, 30000u, 40008u}) {
        std::string image = "ANO_IMAGE" + zeros;
        image[at] = '\1';
        EXPECT_EQ(doubt_about(image), "") << at;
    }
    EXPECT_EQ(doubt_about(zeros), "");
}

TEST(UnlikeFirmware, is_a_text_with_zeros_in_it) {
    std::string text;
    for (int i = 0; i < 2000; ++i) text += "line " + std::to_string(i) + '\n';
    for (const std::size_t zeros : {1u, 2u, 3u, 4u, 2000u}) {
        const std::string some(zeros, '\0');
        expect_doubt(some + text, "text", "");
        expect_doubt("a" + some + text + some + text, "text", "");
        expect_doubt(text + some + text + std::string(3000, '\xFF'), "text", "");
        EXPECT_EQ(doubt_about("a" + some + text + "\x01"), "") << "an image may have texts";
    }
}

TEST(UnlikeFirmware, is_a_picture_or_a_program_of_another_system) {
    expect_doubt(with_bytes("\x89PNG\r\n\x1A\n"), "picture", "");
    expect_doubt(with_bytes("\xFF\xD8\xFF\xE0"), "picture", "");
    expect_doubt(with_bytes("GIF89a"), "picture", "");
    expect_doubt(with_bytes("MZ"), "Windows program", "");
    for (const std::string_view magic : {"\xCF\xFA\xED\xFE", "\xCE\xFA\xED\xFE", "\xFE\xED\xFA\xCE", "\xFE\xED\xFA\xCF"})
        expect_doubt(with_bytes(magic), "macOS program", "");
    expect_doubt(with_bytes("\xCA\xFE\xBA\xBE"), "program", "");
    expect_doubt(with_bytes("DfuSe\x01"), "DfuSe", "");
    expect_doubt(with_bytes({"\x5D\0\0\x80\0", 5}), "lzma", "unlzma");
    expect_doubt("<!DOCTYPE html>" + std::string(300, '\0') + with_bytes(""), "web page", "");
    expect_doubt(with_bytes("<?xml version"), "XML", "");
}

TEST(UnlikeFirmware, is_also_found_after_padding) {
    for (const char pad : {'\0', '\xFF'})
        for (const std::size_t size : {16u, 64u, 5000u, 100000u}) {
            const std::string padding(size, pad);
            expect_doubt(padding + with_bytes("PK\x03\x04"), "ZIP", "unpack");
            expect_doubt(padding + with_bytes("\x89PNG\r\n\x1A\n"), "picture", "");
            expect_doubt(padding + ":10010000214601360121470136007EFE09D2190140\n", "Intel HEX", "objcopy -I ihex");
            expect_doubt(padding + "a readme\n", "text", "");
            expect_doubt("a readme\n" + padding, "text", "");
            EXPECT_EQ(doubt_about(padding + with_bytes({"\0\0\2\x20", 4})), "");
        }
    const std::string end_of_zip{"PK\5\6\0\0\0\0\1\0\1\0\x33\0\0\0\x40\0\0\0\0\0", 22};
    expect_doubt(with_bytes("any bytes") + end_of_zip, "ZIP", "unpack");
}

TEST(UnlikeFirmware, is_erased_flash) { expect_doubt(std::string(3000, '\xFF'), "erased flash", ""); }

TEST(UnlikeFirmware, is_a_text_in_utf_32) {
    for (const bool little : {true, false})
        for (const bool marked : {true, false}) {
            std::string file;
            for (const unsigned c : std::u32string{marked ? U"\uFEFFhello\n说明 🚁" : U"hello, this is a text\n"})
                for (unsigned i = 0; i < 4; ++i) file += static_cast<char>(c >> 8 * (little ? i : 3 - i));
            expect_doubt(file, "text", "");
        }
}

TEST(UnlikeFirmware, is_also_found_after_the_header_of_a_bia) {
    const std::string header = "bia" + std::string(97, '\0');
    expect_doubt(header + ":10010000214601360121470136007EFE09D2190140\n", "Intel HEX", "objcopy -I ihex");
    expect_doubt(header + with_bytes("\x7F"
                                     "ELF"),
                 "ELF", "objcopy -O binary");
    expect_doubt(header + with_bytes("PK\x03\x04"), "ZIP", "unpack");
    expect_doubt(header + "a readme", "text", "");
    EXPECT_EQ(doubt_about(header + with_bytes({"\0\0\2\x20", 4})), "");
}

TEST(UnlikeFirmware, is_not_an_image_that_starts_like_a_compiled_one) {
    for (const std::string_view begin :
         {std::string_view{"\0\0\2\x20\xC1\1\0\x08", 8}, std::string_view{"\x1F\x8B\0\x20\xC1\1\0\x08", 8},
          std::string_view{"\x55\x46\0\x20", 4}, std::string_view{"\xE9\6\2\x20", 4}, std::string_view{"\0\0\0\0S1", 6},
          std::string_view{":\0\1\x20", 4}, std::string_view{"\xFF\xFF", 2}})
        EXPECT_EQ(doubt_about(with_bytes(begin)), "");
}

TEST(UnlikeFirmware, a_log_for_a_terminal_is_text) {
    for (const std::string line : {"\x1b[32mINFO\x1b[0m boot ok\r\n", "N\bNA\bAM\bME\b\n", "a\vb\f\n"}) {
        std::string log;
        for (int i = 0; i < 100; ++i) log += line;
        EXPECT_EQ(doubt_about(log), "this is a text file") << line;
    }
}

TEST(UnlikeFirmware, control_characters_before_hex_records_hide_nothing) {
    EXPECT_EQ(doubt_about("\x02:10010000214601360121470136007EFE09D2190140\r\n").find("this is an Intel HEX file"), 0u);
}

TEST(UnlikeFirmware, a_zip_file_may_have_bytes_before_it_and_a_comment) {
    std::string zip = with_bytes("any bytes");
    zip += std::string{"PK\5\6", 4} + std::string(16, '\0') + std::string{"\x03\0", 2} + "abc";
    EXPECT_EQ(doubt_about(zip), "this is a ZIP file; unpack it first");
    EXPECT_EQ(doubt_about(zip + "d"), "") << "not its end";
    EXPECT_EQ(doubt_about(with_bytes("any bytes") + "PK\5\6"), "");
}

}    // namespace
}    // namespace ano::host::unlike_firmware_tests
