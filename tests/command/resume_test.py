"""`study --resume` goes on with runs of the study, or says that there are none; what is something else it leaves alone."""
import sqlite3
import unittest

from study_harness import StudyTest


class Resume(StudyTest):
    def setUp(self):
        super().setUp()
        self.text = f"graphs: [{self.judged_small_graph()}]\nseeds: 2\nduration: 0.1 s\n"
        (self.folder / "out").mkdir()
        self.file = self.folder / "out/study.sqlite"

    def runs(self):
        return self.table("out", "SELECT count(*) FROM runs")[0][0]

    def test_without_a_table_it_says_that_the_runs_begin_anew(self):
        result = self.study(self.text, "out", "--resume")
        self.assertRegex(result.stderr, r"--resume: .*study\.sqlite held no runs to continue; the study starts anew")
        self.assertEqual(self.runs(), 2)
        self.assertNotIn("starts anew", self.study(self.text, "out", "--resume").stderr)

    def test_with_an_empty_table_it_says_that_the_runs_begin_anew(self):
        self.file.write_bytes(b"")
        result = self.study(self.text, "out", "--resume")
        self.assertRegex(result.stderr, r"--resume: .*study\.sqlite held no runs to continue; the study starts anew")
        self.assertEqual(self.runs(), 2)

    def test_a_table_of_another_kind_is_refused_and_left_as_it_is(self):
        with sqlite3.connect(self.file) as db:
            db.execute("CREATE TABLE addresses(name TEXT)")
        db.close()
        before = self.tables()
        result = self.study(self.text, "out", "--resume", code=2)
        self.assertIn("expected the runs of this study, found it holds no runs of a study", result.stderr)
        self.assertEqual(self.tables(), before)

    def tables(self):
        return [row[0] for row in self.table("out", "SELECT name FROM sqlite_master")]

    def test_a_file_that_is_no_table_is_refused_and_left_as_it_is(self):
        text = b"These are the notes of a user, and they are longer than the header of a table.\n" * 20
        self.file.write_bytes(text)
        result = self.study(self.text, "out", "--resume", code=2)
        self.assertIn("study.sqlite: expected a table of runs, found a file of another kind", result.stderr)
        self.assertEqual(self.file.read_bytes(), text)

    def test_a_table_with_a_run_that_is_none_of_the_study_is_damaged(self):
        self.study(self.text, "out")
        for run in (2, 3_000_000, 10**12, -1, -(2**62)):
            with sqlite3.connect(self.file) as db:
                db.execute("UPDATE runs SET run = ? WHERE run = (SELECT max(run) FROM runs)" if run > 0 else
                           "UPDATE runs SET run = ? WHERE run = (SELECT min(run) FROM runs)", (run,))
            db.close()
            with self.subTest(run=run):
                result = self.study(self.text, "out", "--resume", code=1)
                self.assertRegex(result.stderr, r"study\.sqlite: the table is damaged: it has a run -?\d+ of 2")

    def test_a_table_that_holds_a_program_is_refused(self):
        self.study(self.text, "out")
        whole = self.file.read_bytes()
        endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i AS key, i AS value FROM n"
        wide = "key TEXT, v TEXT, value TEXT AS (printf('%.*c', 900000000, 'x'))"
        for said, program in (("holds the view identity", f"DROP TABLE identity; CREATE VIEW identity AS {endless}"),
                              ("holds the view more", f"CREATE VIEW more AS {endless}"),
                              ("holds the trigger t", "CREATE TRIGGER t AFTER INSERT ON runs BEGIN DELETE FROM names; END"),
                              ("holds the index i", "CREATE INDEX i ON runs(length(printf('%.*c', 900000000, message)))"),
                              ("holds the table t", "CREATE VIRTUAL TABLE t USING fts5(a)"),
                              ("lacks tables", "DROP TABLE curves"),
                              ("was written by another version", f"DROP TABLE identity; CREATE TABLE identity({wide})")):
            with sqlite3.connect(self.file) as db:
                db.executescript(program)
            db.close()
            with self.subTest(said):
                result = self.study(self.text, "out", "--resume", code=2)
                self.assertIn(f"study.sqlite: expected the runs of this study, found it {said}", result.stderr)
            self.file.write_bytes(whole)

    def test_a_table_that_lacks_what_a_run_told_beside_its_metrics_is_read(self):
        self.study(self.text, "out")
        with sqlite3.connect(self.file) as db:
            db.execute("UPDATE runs SET more = '{}'")
        db.close()
        self.study(self.text, "out", "--resume")

    def test_the_runs_of_another_study_are_refused(self):
        self.study(self.text, "out")
        result = self.study(self.text.replace("seeds: 2", "seeds: 3"), "out", "--resume", code=2)
        self.assertIn("expected the runs of this study", result.stderr)
        self.assertEqual(self.runs(), 2)


if __name__ == "__main__":
    unittest.main()
