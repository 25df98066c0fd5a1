// Jobs that are split, killed, resumed and put together again.
#include "app/io/work_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "app/io/shard.hpp"
#include "app/io/work_journal.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using testing::HasSubstr;

/// The faults of what `call` throws, as a user sees them; empty where it throws nothing.
template <class Call>
std::string faults_of(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    std::string text;
    for (const Fault& fault : error.faults()) text += to_text(fault) + "\n";
    return text;
  }
  return "";
}

TEST(Shards, HoldEachItemOnceWhateverTheirNumber) {
  for (const int count : {1, 2, 3, 7, 50}) {
    for (std::size_t item = 0; item < 40; ++item) {
      int holders = 0;
      for (int index = 1; index <= count; ++index) holders += Shard{index, count}.holds(item) ? 1 : 0;
      EXPECT_EQ(holders, 1) << item << " of " << count;
    }
  }
}

TEST(Shards, AreReadStrictly) {
  EXPECT_EQ(parse_shard("2/4").to_text(), "2/4");
  for (const char* bad : {"", "/", "0/4", "5/4", "-1/4", "1/0", "1", "1/4/2", "a/b", "1.0/4", "1/100001",
                          "99999999999999999999/99999999999999999999"}) {
    EXPECT_THAT(faults_of([&] { parse_shard(bad); }), HasSubstr("--shard")) << bad;
  }
}

class Work : public testing::Test {
 protected:
  static WorkJob job(const std::string& scenario, Shard shard = {}) {
    return {{{"command", "sweep"}, {"scenario", scenario}}, shard};
  }
  static void write_results(WorkFolder& folder, const std::map<std::string, std::string>& results,
                            bool finished, const std::map<std::string, std::string>& untracked = {}) {
    WorkResults all = folder.begin_results();
    for (const auto& [name, contents] : results) all.write(name, contents);
    for (const auto& [name, contents] : untracked) all.write_untracked(name, contents);
    folder.commit_results(std::move(all), finished);
  }
  void finish(const std::string& folder, const WorkJob& work, const std::string& result) const {
    WorkFolder open(dir / folder, work, false, Overwrite::refuse);
    write_results(open, {{"trials.csv", result}}, true);
  }
  std::string contents(const std::filesystem::path& file) const { return read_file_bytes(file, 1u << 20); }

  test::TemporaryFolder temporary;
  std::filesystem::path dir = temporary.path();
};

TEST_F(Work, AJournalKeepsWhatWasNoted) {
  const std::string odd = "1,\"two\"\n\ttab \xc3\xa9";
  {
    WorkJournal journal(dir / "journal", "job");
    journal.add("a", odd);
    journal.add("b", "");
    journal.add("a", "another value for a known key");
    EXPECT_EQ(journal.find("a"), odd);  // while it is written, too
    EXPECT_EQ(journal.find("b"), "");
  }
  WorkJournal again(dir / "journal", "job");
  ASSERT_EQ(again.size(), 2u);
  again.add("later", "more");
  EXPECT_EQ(again.find("later"), "more");
  EXPECT_EQ(*again.find("a"), odd);
  EXPECT_EQ(*again.find("b"), "");
  EXPECT_EQ(again.find("c"), std::nullopt);
  EXPECT_TRUE(again.has("a"));
  EXPECT_FALSE(again.has("c"));
}

TEST_F(Work, NotesAreFoundInTheirFile) {
  const std::string many(3000, 'x');  // lines longer and shorter than what is read at once
  std::string text;
  for (int k = 0; k < 100; ++k)
    text += note_line("key " + std::to_string(k), many + "\n" + std::to_string(k));
  std::ofstream(dir / "notes") << text;
  const NoteFile notes(dir / "notes");
  for (int k = 0; k < 100; ++k)
    EXPECT_EQ(notes.find("key " + std::to_string(k)), many + "\n" + std::to_string(k));
  EXPECT_EQ(notes.find("key 100"), std::nullopt);
  std::ofstream(dir / "bad") << note_line("a", "b") << "[\"a\",3]\n";
  EXPECT_THAT(faults_of([&] { NoteFile(dir / "bad"); }), HasSubstr("bad:2"));
  std::ofstream(dir / "short") << "[\"a\",\"b\"]";
  EXPECT_THAT(faults_of([&] { NoteFile(dir / "short"); }), HasSubstr("unfinished"));
  EXPECT_THAT(faults_of([&] { NoteFile(dir / "none"); }), HasSubstr("none"));
}

TEST_F(Work, ResultsWrittenPieceByPieceAreThoseWrittenWhole) {
  finish("whole", job("x"), "one\ntwo\n");
  WorkFolder folder(dir / "pieces", job("x"), false, Overwrite::refuse);
  WorkResults results = folder.begin_results();
  for (const char* piece : {"one\n", "", "two\n"}) results.append("trials.csv", piece);
  folder.commit_results(std::move(results), true);
  for (const char* name : {"trials.csv", "manifest.json"})
    EXPECT_EQ(contents(dir / "pieces" / name), contents(dir / "whole" / name)) << name;
}

TEST_F(Work, AJournalCutAnywhereIsAWholeShorterOne) {
  {
    WorkJournal journal(dir / "journal", "job");
    for (int k = 0; k < 5; ++k) journal.add("key " + std::to_string(k), "value\n" + std::to_string(k));
  }
  const std::string whole = contents(dir / "journal");
  std::size_t last = 0;
  for (std::size_t length = 0; length <= whole.size(); ++length) {
    std::ofstream(dir / "journal", std::ios::trunc) << whole.substr(0, length);
    {
      WorkJournal journal(dir / "journal", "job");
      EXPECT_GE(journal.size(), last);
      last = journal.size();
      for (int k = 0; k < 5; ++k) journal.add("key " + std::to_string(k), "value\n" + std::to_string(k));
    }
    EXPECT_EQ(contents(dir / "journal"), whole) << length;
  }
  EXPECT_EQ(last, 5u);
}

TEST_F(Work, AJournalSurvivesAKilledProcess) {
  const pid_t child = ::fork();
  if (child == 0) {
    WorkJournal journal(dir / "journal", "job");
    for (int k = 0; k < 3; ++k) journal.add(std::to_string(k), "done");
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WorkJournal(dir / "journal", "job").size(), 3u);
}

TEST_F(Work, AJournalRefusesOtherJobsDamageAndASecondProcess) {
  { WorkJournal(dir / "journal", "job").add("a", "b"); }
  EXPECT_THAT(faults_of([&] { WorkJournal(dir / "journal", "other"); }), HasSubstr("another job"));
  const WorkJournal held(dir / "journal", "job");
  EXPECT_THAT(faults_of([&] { WorkJournal(dir / "journal", "job"); }), HasSubstr("another process"));
  for (const char* bad : {"nonsense\n", "[\"a\",\"b\"]\n", "[[[[[[\n", "[\"ballservo journal 1\",1]\n"}) {
    std::ofstream(dir / "bad", std::ios::trunc) << bad;
    EXPECT_THAT(faults_of([&] { WorkJournal(dir / "bad", "job"); }), HasSubstr("bad:1: found a damaged line"))
        << bad;
  }
}

TEST_F(Work, AFolderIsResumedByItsOwnJobOnly) {
  { WorkFolder(dir / "out", job("x"), false, Overwrite::refuse).journal().add("0", "done"); }
  EXPECT_THAT(faults_of([&] { WorkFolder(dir / "out", job("x"), false, Overwrite::refuse); }),
              HasSubstr("--resume"));
  EXPECT_THAT(faults_of([&] { WorkFolder(dir / "out", job("y"), true, Overwrite::refuse); }),
              HasSubstr("another job"));
  EXPECT_THAT(faults_of([&] {
                WorkFolder(dir / "out", job("x", {1, 2}), true, Overwrite::refuse);
              }),
              HasSubstr("another job"));
  {
    WorkFolder again(dir / "out", job("x"), true, Overwrite::refuse);
    EXPECT_EQ(again.journal().size(), 1u);
    write_results(again, {{"trials.csv", "part\n"}}, false);
    EXPECT_EQ(contents(dir / "out/trials.csv"), "part\n");
    EXPECT_FALSE(std::filesystem::exists(dir / "out/manifest.json"));
    write_results(again, {{"trials.csv", "whole\n"}}, true, {{"timing.json", "{}"}});
  }
  EXPECT_EQ(contents(dir / "out/trials.csv"), "whole\n");
  EXPECT_FALSE(std::filesystem::exists(dir / "out/unfinished.journal"));
  EXPECT_TRUE(WorkFolder(dir / "out", job("x"), true, Overwrite::refuse).already_finished());
  EXPECT_THAT(faults_of([&] { WorkFolder(dir / "out", job("y"), true, Overwrite::refuse); }),
              HasSubstr("differs in scenario"));
  EXPECT_THAT(faults_of([&] { WorkFolder(dir / "out", job("x"), false, Overwrite::refuse); }),
              HasSubstr("not empty"));
  EXPECT_EQ(WorkFolder(dir / "out", job("y"), false, Overwrite::allow).journal().size(), 0u);
}

TEST_F(Work, ShardsAreReadInTheirOrder) {
  finish("b", job("x", {2, 3}), "2");
  finish("c", job("x", {3, 3}), "3");
  finish("a", job("x", {1, 3}), "1");
  const MergeableShards merge = read_shards({dir / "b", dir / "c", dir / "a"});
  ASSERT_EQ(merge.shards.size(), 3u);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(merge.shards[static_cast<std::size_t>(k)].shard.index, k + 1);
  EXPECT_EQ(merge.description["scenario"], "x");
}

TEST_F(Work, ShardsThatDoNotFitAreAllNamed) {
  finish("a", job("x", {1, 5}), "1");
  finish("b", job("y", {2, 5}), "2");
  finish("twin", job("x", {1, 5}), "1");
  finish("changed", job("x", {3, 5}), "3");
  finish("count", job("x", {2, 4}), "2");
  std::ofstream(dir / "changed/trials.csv") << "edited";
  { WorkFolder(dir / "begun", job("x", {4, 5}), false, Overwrite::refuse); }
  const std::string faults = faults_of([&] {
    read_shards(
        {dir / "a", dir / "b", dir / "twin", dir / "changed", dir / "count", dir / "begun", dir / "no"});
  });
  EXPECT_THAT(faults, HasSubstr("differ in scenario"));
  EXPECT_THAT(faults, HasSubstr("each part once"));
  EXPECT_THAT(faults, HasSubstr("trials.csv: found not what the job wrote"));
  EXPECT_THAT(faults, HasSubstr("part 2/4"));
  EXPECT_THAT(faults, HasSubstr("an unfinished job"));
  EXPECT_THAT(faults, HasSubstr("no results of a job"));
  EXPECT_THAT(faults, HasSubstr("parts 2/5, 4/5, 5/5 missing"));
  EXPECT_THAT(faults_of([&] { read_shards({}); }), HasSubstr("no folders"));
}

TEST_F(Work, AManifestIsNotBelieved) {
  for (const char* bad : {"", "{}", "[]", "{\"job\": {}, \"shard\": \"3/2\", \"sha256\": {}}",
                          "{\"job\": {}, \"shard\": \"1/1\", \"sha256\": {\"../../etc/passwd\": \"0\"}}",
                          "{\"job\": {}, \"shard\": \"1/1\", \"sha256\": {\"/etc/passwd\": \"0\"}}"}) {
    std::filesystem::create_directory(dir / "out");
    std::ofstream(dir / "out/manifest.json", std::ios::trunc) << bad;
    EXPECT_THAT(faults_of([&] { read_shards({dir / "out"}); }), HasSubstr("manifest.json")) << bad;
  }
  std::ofstream(dir / "out/manifest.json", std::ios::trunc)
      << "{\"job\": {\"a\":" + std::string(100000, '[') + std::string(100000, ']') +
             "}, \"shard\": \"1/2\", \"sha256\": {}}";
  EXPECT_THAT(faults_of([&] { read_shards({dir / "out"}); }), HasSubstr("missing"));
}

}  // namespace
}  // namespace ballservo
