#include <mqtt/spool.hpp>

#include <sqlite3.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <system_error>

namespace anogate {
namespace {

constexpr char schema[] =
    "PRAGMA user_version = 1;"
    "CREATE TABLE IF NOT EXISTS batch (id INTEGER PRIMARY KEY, keep INTEGER, time INTEGER, records INTEGER, body BLOB);"
    "CREATE INDEX IF NOT EXISTS batch_order ON batch (keep, id);"
    "CREATE TABLE IF NOT EXISTS request (key TEXT PRIMARY KEY, time INTEGER, response TEXT) WITHOUT ROWID;";
constexpr char options[] =
    "PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA journal_size_limit = 4194304;"
    "PRAGMA cache_size = -512;";
constexpr std::int64_t version = 1;
constexpr std::uint64_t kept_requests_s = 2 * 3600;
constexpr std::uint64_t min_bytes = 256 * 1024;
constexpr std::int64_t clock_was_set =
    1'577'836'800;    // 2020: what is older was written before the clock was set, and has no age

std::string file_in(const std::string& folder) { return folder + "/spool.db"; }

bool is_damage(int code) { return (code & 0xFF) == SQLITE_CORRUPT || (code & 0xFF) == SQLITE_NOTADB; }

}    // namespace

class Spool::Database {
public:
    explicit Database(const std::string& file) {
        code_ = sqlite3_open_v2(file.c_str(), &sqlite_,
                                SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_PRIVATECACHE,
                                nullptr);
    }
    Database(const Database&) = delete;
    Database& operator=(const Database&) = delete;
    ~Database() { sqlite3_close_v2(sqlite_); }

    bool run(const char* sql) { return note(sqlite3_exec(sqlite_, sql, nullptr, nullptr, nullptr)); }
    /// False: an error. It is kept until the next one.
    bool note(int code) {
        const bool is_good = code == SQLITE_OK || code == SQLITE_ROW || code == SQLITE_DONE;
        if (!is_good) code_ = code;
        return is_good;
    }
    int code() const { return code_; }
    void forget_error() { code_ = SQLITE_OK; }
    Unexpected fault() const { return Unexpected{"spool: " + std::string{sqlite3_errstr(code_)}}; }
    sqlite3* get() const { return sqlite_; }
    std::int64_t number(const char* sql);

private:
    sqlite3* sqlite_ = nullptr;
    int code_ = SQLITE_OK;
};

class Spool::Statement {
public:
    Statement(Database& database, const char* sql) : database_{database} {
        database.note(sqlite3_prepare_v2(database.get(), sql, -1, &statement_, nullptr));
    }
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;
    ~Statement() { sqlite3_finalize(statement_); }

    Statement& with(std::int64_t number) {
        sqlite3_bind_int64(statement_, ++bound_, number);
        return *this;
    }
    Statement& with(std::uint64_t number) { return with(static_cast<std::int64_t>(number)); }
    Statement& with_text(std::string_view text) {
        sqlite3_bind_text(statement_, ++bound_, text.data(), static_cast<int>(text.size()), SQLITE_STATIC);
        return *this;
    }
    Statement& with_bytes(std::string_view bytes) {
        sqlite3_bind_blob(statement_, ++bound_, bytes.data(), static_cast<int>(bytes.size()), SQLITE_STATIC);
        return *this;
    }
    bool has_row() { return step() == SQLITE_ROW; }
    bool run() { return database_.note(step()); }
    std::int64_t number(int column) const { return sqlite3_column_int64(statement_, column); }
    std::string bytes(int column) const {
        const void* const bytes = sqlite3_column_blob(statement_, column);
        const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
        return bytes == nullptr ? std::string{} : std::string{static_cast<const char*>(bytes), size};
    }
    void again() {
        sqlite3_reset(statement_);
        bound_ = 0;
    }

private:
    int step() {
        if (statement_ == nullptr) return database_.code();
        const int code = sqlite3_step(statement_);
        database_.note(code);
        return code;
    }

    Database& database_;
    sqlite3_stmt* statement_ = nullptr;
    int bound_ = 0;
};

std::int64_t Spool::Database::number(const char* sql) {
    Statement statement{*this, sql};
    return statement.has_row() ? statement.number(0) : 0;
}

Spool::Spool(std::string folder, const SpoolLimits& limits, std::function<void(std::string)> report)
    : folder_{std::move(folder)}, limits_{limits}, report_{std::move(report)} {
    limits_.bytes = std::max(limits_.bytes, min_bytes);
}
Spool::Spool(Spool&&) noexcept = default;
Spool& Spool::operator=(Spool&&) noexcept = default;
Spool::~Spool() = default;

Expected<Spool> Spool::open(const std::string& folder, const SpoolLimits& limits, std::function<void(std::string)> report) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return Unexpected{"spool: " + folder + ": " + error.message()};
    Spool spool{folder, limits, std::move(report)};
    auto opened = spool.open_database();
    if (!opened && spool.database_ && is_damage(spool.database_->code()) && spool.set_aside()) opened = spool.open_database();
    if (!opened) return Unexpected{opened.error()};
    return spool;
}

Expected<void> Spool::open_database() {
    database_ = std::make_unique<Database>(file_in(folder_));
    if (database_->code() != SQLITE_OK || !database_->run(options)) return database_->fault();
    const std::int64_t found = database_->number("PRAGMA user_version");
    if (found != 0 && found != version)
        return Unexpected{"spool: " + file_in(folder_) + " is of another version of anogate-mqtt"};
    Statement check{*database_, "PRAGMA quick_check(1)"};
    if (check.has_row() && check.bytes(0) != "ok") database_->note(SQLITE_CORRUPT);
    if (database_->code() != SQLITE_OK || !database_->run(schema)) return database_->fault();
    records_ = static_cast<std::uint64_t>(database_->number("SELECT coalesce(sum(records), 0) FROM batch"));
    last_id_ = std::max(last_id_, database_->number("SELECT coalesce(max(id), 0) FROM batch"));
    return database_->code() == SQLITE_OK ? Expected<void>{} : database_->fault();
}

// False: it could not be renamed.
bool Spool::set_aside() {
    database_.reset();
    const std::string file = file_in(folder_);
    const std::string aside = folder_ + "/damaged-" + std::to_string(std::time(nullptr)) + ".db";
    for (const char* part : {"-wal", "-shm", "-journal"}) std::rename((file + part).c_str(), (aside + part).c_str());
    if (std::rename(file.c_str(), aside.c_str()) != 0) return false;
    done_.clear();
    records_ = 0;
    report_("the spool was damaged; it is kept as " + aside + ", and a new one is used");
    return true;
}

void Spool::set_aside_if_damaged() {
    if (database_ && is_damage(database_->code()) && set_aside()) open_database();
}

std::uint64_t Spool::bytes() {
    if (!database_) return 0;
    const std::int64_t pages = database_->number("PRAGMA page_count") - database_->number("PRAGMA freelist_count");
    return static_cast<std::uint64_t>(pages * database_->number("PRAGMA page_size"));
}

Expected<void> Spool::write(std::span<const Batch> batches, std::span<const std::int64_t> done, std::uint64_t now_s) {
    done_.insert(done_.end(), done.begin(), done.end());
    if (!database_) return Unexpected{"spool: it is not open"};
    const std::uint64_t records = records_, dropped = dropped_;
    auto written = write_once(batches, done_, now_s);
    if (written) {
        done_.clear();
        return written;
    }
    database_->run("ROLLBACK");
    records_ = records, dropped_ = dropped;
    const bool was_damaged = is_damage(database_->code());
    set_aside_if_damaged();
    if (was_damaged && database_) return write_once(batches, {}, now_s);
    if (database_) database_->forget_error();
    return written;
}

Expected<void> Spool::write_once(std::span<const Batch> batches, std::span<const std::int64_t> done, std::uint64_t now_s) {
    if (!database_->run("BEGIN IMMEDIATE")) return database_->fault();
    Statement remove{*database_, "DELETE FROM batch WHERE id = ? RETURNING records"};
    for (const std::int64_t id : done) {
        if (remove.with(id).has_row()) records_ -= static_cast<std::uint64_t>(remove.number(0));
        remove.again();
    }
    Statement add{*database_, "INSERT INTO batch (id, keep, time, records, body) VALUES (?, ?, ?, ?, ?)"};
    for (const Batch& batch : batches) {
        add.with(++last_id_)
            .with(static_cast<std::int64_t>(batch.keep))
            .with(batch.time_s)
            .with(batch.records)
            .with_bytes(batch.body);
        if (!add.run()) return database_->fault();
        add.again();
        records_ += batch.records;
    }
    if (auto kept = drop_oldest(now_s); !kept) return kept;
    Statement forget{*database_, "DELETE FROM request WHERE time < ? AND time > ?"};
    if (!forget.with(static_cast<std::int64_t>(now_s) - static_cast<std::int64_t>(kept_requests_s)).with(clock_was_set).run())
        return database_->fault();
    return database_->run("COMMIT") ? Expected<void>{} : database_->fault();
}

Expected<void> Spool::drop_oldest(std::uint64_t now_s) {
    const auto count = [this](const Statement& row) {
        records_ -= static_cast<std::uint64_t>(row.number(0));
        dropped_ += static_cast<std::uint64_t>(row.number(0));
    };
    Statement old{*database_, "DELETE FROM batch WHERE time < ? AND time > ? RETURNING records"};
    old.with(static_cast<std::int64_t>(now_s) - static_cast<std::int64_t>(limits_.age_s)).with(clock_was_set);
    while (old.has_row()) count(old);
    Statement drop{*database_, "DELETE FROM batch WHERE id = (SELECT id FROM batch ORDER BY keep, id LIMIT 1) RETURNING records"};
    while (bytes() > limits_.bytes) {
        if (!drop.has_row()) break;
        count(drop);
        drop.again();
    }
    return {};
}

std::optional<SpooledBatch> Spool::next() {
    if (!database_) return std::nullopt;
    std::optional<SpooledBatch> found;
    {
        Statement rows{*database_, "SELECT id, keep, time, records, body FROM batch ORDER BY keep DESC, id"};
        while (!found && rows.has_row()) {
            const std::int64_t id = rows.number(0);
            if (std::find(done_.begin(), done_.end(), id) != done_.end()) continue;
            found = SpooledBatch{id,
                                 {static_cast<Keep>(rows.number(1)), static_cast<std::uint64_t>(rows.number(3)),
                                  static_cast<std::uint64_t>(rows.number(2)), rows.bytes(4)}};
        }
    }
    set_aside_if_damaged();
    return found;
}

Expected<bool> Spool::begin_request(const std::string& key, std::uint64_t now_s) {
    if (!database_) return Unexpected{"spool: it is not open"};
    Statement add{*database_, "INSERT OR IGNORE INTO request (key, time) VALUES (?, ?)"};
    if (!add.with_text(key).with(now_s).run()) return database_->fault();
    return sqlite3_changes(database_->get()) == 1;
}

Expected<void> Spool::end_request(const std::string& key, const std::string& response) {
    if (!database_) return Unexpected{"spool: it is not open"};
    Statement set{*database_, "UPDATE request SET response = ? WHERE key = ?"};
    return set.with_text(response).with_text(key).run() ? Expected<void>{} : database_->fault();
}

std::vector<KnownRequest> Spool::requests() {
    std::vector<KnownRequest> known;
    if (!database_) return known;
    Statement rows{*database_, "SELECT key, response FROM request ORDER BY time"};
    while (rows.has_row()) known.push_back({rows.bytes(0), rows.bytes(1)});
    return known;
}

}    // namespace anogate
