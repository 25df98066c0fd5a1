// Jobs that are split, killed, resumed and put together again.
#include "app/io/work_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "app/io/journal.hpp"
#include "calibration/base/system_file.hpp"
#include "tests/support/faults.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using test::fault_lines;
using testing::HasSubstr;

const NoteCheck any = [](const std::string&, const std::string&) { return true; };

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
    EXPECT_THAT(fault_lines([&] { parse_shard(bad); }), HasSubstr("--shard")) << bad;
  }
}

class Work : public testing::Test {
 protected:
  static WorkJob job(const std::string& scenario, Shard shard = {}) {
    return {{{"command", "sweep"}, {"scenario", scenario}}, shard};
  }
  void finish(const std::string& folder, const WorkJob& work, const std::string& result) const {
    WorkFolder open(dir / folder, work, false, Overwrite::refuse, any);
    open.write("trials.csv", result);
    open.commit_finished();
  }
  std::string contents(const std::filesystem::path& file) const { return read_file_bytes(file, 1u << 20); }

  test::TemporaryFolder temporary;
  std::filesystem::path dir = temporary.path();
};

TEST_F(Work, AJournalKeepsWhatWasNoted) {
  const std::string odd = "1,\"two\"\n\ttab \xc3\xa9";
  {
    Journal journal(dir / "journal", "job", any);
    journal.add("a", odd);
    journal.add("b", "");
    journal.add("a", "another value for a known key");
    EXPECT_EQ(journal.find("a"), odd);  // while it is written, too
    EXPECT_EQ(journal.find("b"), "");
  }
  Journal again(dir / "journal", "job", any);
  ASSERT_EQ(again.size(), 2u);
  again.add("later", "more");
  EXPECT_EQ(again.find("later"), "more");
  EXPECT_EQ(*again.find("a"), odd);
  EXPECT_EQ(*again.find("b"), "");
  EXPECT_EQ(again.find("c"), std::nullopt);
  EXPECT_TRUE(again.has("a"));
  EXPECT_FALSE(again.has("c"));
}

TEST_F(Work, AJournalTakesInThoseOfParts) {
  const std::string many(3000, 'x');
  for (const int part : {0, 1}) {
    Journal journal(dir / ("part " + std::to_string(part)), "job", any);
    for (int k = part; k < 100; k += 2)
      journal.add("key " + std::to_string(k), many + "\n" + std::to_string(k));
  }
  Journal whole(dir / "whole", "another job", any);
  whole.add_part(dir / "part 1");
  whole.add_part(dir / "part 0");
  ASSERT_EQ(whole.size(), 100u);
  for (int k = 0; k < 100; ++k)
    EXPECT_EQ(whole.find("key " + std::to_string(k)), many + "\n" + std::to_string(k));
  const std::string first = "[\"ballservo journal 1\",\"job\"]\n";
  std::ofstream(dir / "bad") << first << "[\"a\",3]\n";
  EXPECT_THAT(fault_lines([&] { whole.add_part(dir / "bad"); }), HasSubstr("bad:2"));
  std::ofstream(dir / "short") << first << "[\"a\",\"b\"]";
  EXPECT_THAT(fault_lines([&] { whole.add_part(dir / "short"); }), HasSubstr("unfinished"));
  EXPECT_THAT(fault_lines([&] { whole.add_part(dir / "none"); }), HasSubstr("none"));
  ASSERT_EQ(::mkfifo((dir / "pipe").c_str(), 0600), 0);  // must not be waited for
  EXPECT_THAT(fault_lines([&] { whole.add_part(dir / "pipe"); }), HasSubstr("pipe"));
  EXPECT_THAT(fault_lines([&] { Journal(dir / "pipe", "job", any); }), HasSubstr("pipe"));
}

TEST_F(Work, ResultsWrittenPieceByPieceAreThoseWrittenWhole) {
  finish("whole", job("x"), "one\ntwo\n");
  WorkFolder folder(dir / "pieces", job("x"), false, Overwrite::refuse, any);
  for (const char* piece : {"one\n", "", "two\n"}) folder.write("trials.csv", piece);
  EXPECT_FALSE(std::filesystem::exists(dir / "pieces/trials.csv"));
  folder.commit_finished();
  for (const char* name : {"trials.csv", "manifest.json"})
    EXPECT_EQ(contents(dir / "pieces" / name), contents(dir / "whole" / name)) << name;
}

TEST_F(Work, AFinishedPartKeepsItsJournalWhereItIsAskedTo) {
  WorkFolder folder(dir / "out", job("x", {1, 2}), false, Overwrite::refuse, any);
  folder.journal().add("a", "b");
  folder.commit_finished("notes.jsonl");
  EXPECT_FALSE(std::filesystem::exists(dir / "out/unfinished.journal"));
  EXPECT_EQ(Journal(dir / "out/notes.jsonl", job("x", {1, 2}).sha256(), any).find("a"), "b");
}

TEST_F(Work, AJournalCutAnywhereIsAWholeShorterOne) {
  {
    Journal journal(dir / "journal", "job", any);
    for (int k = 0; k < 5; ++k) journal.add("key " + std::to_string(k), "value\n" + std::to_string(k));
  }
  const std::string whole = contents(dir / "journal");
  std::size_t last = 0;
  for (std::size_t length = 0; length <= whole.size(); ++length) {
    std::ofstream(dir / "journal", std::ios::trunc) << whole.substr(0, length);
    {
      Journal journal(dir / "journal", "job", any);
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
    Journal journal(dir / "journal", "job", any);
    for (int k = 0; k < 3; ++k) journal.add(std::to_string(k), "done");
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(Journal(dir / "journal", "job", any).size(), 3u);
}

TEST_F(Work, AJournalRefusesOtherJobsDamageAndASecondProcess) {
  { Journal(dir / "journal", "job", any).add("a", "b"); }
  EXPECT_THAT(fault_lines([&] { Journal(dir / "journal", "other", any); }), HasSubstr("another job"));
  const Journal held(dir / "journal", "job", any);
  EXPECT_THAT(fault_lines([&] { Journal(dir / "journal", "job", any); }), HasSubstr("another process"));
  for (const char* bad : {"nonsense\n", "[\"a\",\"b\"]\n", "[[[[[[\n", "[\"ballservo journal 1\",1]\n"}) {
    std::ofstream(dir / "bad", std::ios::trunc) << bad;
    EXPECT_THAT(fault_lines([&] { Journal(dir / "bad", "job", any); }),
                HasSubstr("bad:1: found a damaged line"))
        << bad;
  }
}

TEST_F(Work, AFolderIsResumedByItsOwnJobOnly) {
  { WorkFolder(dir / "out", job("x"), false, Overwrite::refuse, any).journal().add("0", "done"); }
  EXPECT_THAT(fault_lines([&] { WorkFolder(dir / "out", job("x"), false, Overwrite::refuse, any); }),
              HasSubstr("--resume"));
  EXPECT_THAT(fault_lines([&] { WorkFolder(dir / "out", job("y"), true, Overwrite::refuse, any); }),
              HasSubstr("another job"));
  EXPECT_THAT(fault_lines([&] {
                WorkFolder(dir / "out", job("x", {1, 2}), true, Overwrite::refuse, any);
              }),
              HasSubstr("another job"));
  {
    WorkFolder again(dir / "out", job("x"), true, Overwrite::refuse, any);
    EXPECT_EQ(again.journal().size(), 1u);
    again.write("trials.csv", "part\n");
    again.commit_unfinished();
    EXPECT_EQ(contents(dir / "out/trials.csv"), "part\n");
    EXPECT_FALSE(std::filesystem::exists(dir / "out/manifest.json"));
    again.write("trials.csv", "whole\n");
    again.write_varying("timing.json", "{}");
    again.commit_finished();
  }
  EXPECT_EQ(contents(dir / "out/trials.csv"), "whole\n");
  EXPECT_FALSE(std::filesystem::exists(dir / "out/unfinished.journal"));
  EXPECT_TRUE(WorkFolder(dir / "out", job("x"), true, Overwrite::refuse, any).already_finished());
  EXPECT_THAT(fault_lines([&] { WorkFolder(dir / "out", job("y"), true, Overwrite::refuse, any); }),
              HasSubstr("differs in scenario"));
  EXPECT_THAT(fault_lines([&] { WorkFolder(dir / "out", job("x"), false, Overwrite::refuse, any); }),
              HasSubstr("not empty"));
  EXPECT_EQ(WorkFolder(dir / "out", job("y"), false, Overwrite::allow, any).journal().size(), 0u);
}

TEST_F(Work, ShardsAreReadInTheirOrder) {
  finish("b", job("x", {2, 3}), "2");
  finish("c", job("x", {3, 3}), "3");
  finish("a", job("x", {1, 3}), "1");
  const MergeableShards merge = read_shards({dir / "b", dir / "c", dir / "a"});
  EXPECT_EQ(merge.folders, (std::vector{dir / "a", dir / "b", dir / "c"}));
  EXPECT_EQ(merge.description["scenario"], "x");
}

TEST_F(Work, ShardsThatDoNotFitAreAllNamed) {
  finish("a", job("x", {1, 5}), "1");
  finish("b", job("y", {2, 5}), "2");
  finish("twin", job("x", {1, 5}), "1");
  finish("changed", job("x", {3, 5}), "3");
  finish("count", job("x", {2, 4}), "2");
  std::ofstream(dir / "changed/trials.csv") << "edited";
  { WorkFolder(dir / "begun", job("x", {4, 5}), false, Overwrite::refuse, any); }
  const std::string faults = fault_lines([&] {
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
  EXPECT_THAT(fault_lines([&] { read_shards({}); }), HasSubstr("no folders"));
}

TEST_F(Work, AManifestIsNotBelieved) {
  for (const char* bad : {"", "{}", "[]", "{\"job\": {}, \"shard\": \"3/2\", \"sha256\": {}}",
                          "{\"job\": {}, \"shard\": \"1/1\", \"sha256\": {\"../../etc/passwd\": \"0\"}}",
                          "{\"job\": {}, \"shard\": \"1/1\", \"sha256\": {\"/etc/passwd\": \"0\"}}"}) {
    std::filesystem::create_directory(dir / "out");
    std::ofstream(dir / "out/manifest.json", std::ios::trunc) << bad;
    EXPECT_THAT(fault_lines([&] { read_shards({dir / "out"}); }), HasSubstr("manifest.json")) << bad;
  }
  std::ofstream(dir / "out/manifest.json", std::ios::trunc)
      << "{\"job\": {\"a\":" + std::string(100000, '[') + std::string(100000, ']') +
             "}, \"shard\": \"1/2\", \"sha256\": {}}";
  EXPECT_THAT(fault_lines([&] { read_shards({dir / "out"}); }), HasSubstr("missing"));
}

}  // namespace
}  // namespace ballservo
