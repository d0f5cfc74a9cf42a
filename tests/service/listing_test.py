#!/usr/bin/python3
"""What jobs are found by: labels, owner, the beginning of an id; and what is kept with them."""
import os
import pwd

import grpc

from dccast.v1 import job_pb2, service_pb2
from support import ServiceTest, fake_case, main


class Listing(ServiceTest):
    def found(self, **filters):
        answer = self.client.stub.ListJobs(service_pb2.ListJobsRequest(**filters), timeout=10)
        return [job.id for job in answer.jobs]

    def test_labels(self):
        both = self.client.submit(fake_case("steps=1"), labels=["trial-7", "night shift"])
        one = self.client.submit(fake_case("steps=1"), labels=["trial-7"])
        none = self.client.submit(fake_case("steps=1"))
        self.assertEqual(list(both.labels), ["trial-7", "night shift"])
        self.assertEqual(self.found(), [none.id, one.id, both.id])
        self.assertEqual(self.found(labels=["trial-7"]), [one.id, both.id])
        self.assertEqual(self.found(labels=["trial-7", "night shift"]), [both.id])
        self.assertEqual(self.found(labels=["trial"]), [])
        self.assertEqual(self.found(labels=["%"]), [])
        self.daemon.terminate()
        self.restart()
        self.assertEqual(list(self.client.job(both.id).labels), ["trial-7", "night shift"])

    def test_labels_that_are_none(self):
        for labels in ([""], ["two\nlines"], ["x" * 65], ["a"] * 21):
            self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, fake_case("steps=1"),
                         labels=labels)

    def test_owner(self):
        job = self.client.submit(fake_case("steps=1"))
        me = pwd.getpwuid(os.getuid()).pw_name
        self.assertEqual(self.found(owner=me), [job.id])
        self.assertEqual(self.found(owner="nobody at all"), [])

    def test_the_beginning_of_an_id(self):
        ids = [self.client.submit(fake_case("steps=1")).id for _ in range(30)]
        for job_id in ids:
            self.assertIn(job_id, self.found(id_prefix=job_id[:2]))
            self.assertEqual(self.found(id_prefix=job_id), [job_id])
        self.assertEqual(self.found(id_prefix="~"), [])
        page = self.client.stub.ListJobs(service_pb2.ListJobsRequest(page_size=10))
        rest = self.client.stub.ListJobs(service_pb2.ListJobsRequest(
            page_size=100, page_token=page.next_page_token))
        self.assertEqual(len(page.jobs) + len(rest.jobs), 30)

    def test_changes_are_kept(self):
        changes = [job_pb2.CaseChange(key="schedule.water_flow.scale", value="0.8 until 100 mm")]
        job = self.client.submit(fake_case("steps=1"), changes=changes)
        self.assertEqual(list(job.changes), changes)
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        self.daemon.terminate()
        self.restart()
        self.assertEqual(list(self.client.job(job.id).changes), changes)
        many = [job_pb2.CaseChange(key="title", value="x" * 20000)]
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, fake_case("steps=1"),
                     changes=many)

    def test_a_job_that_is_being_cancelled_cannot_be_deleted_yet(self):
        job = self.client.submit(fake_case("steps=1000 sleep_ms=300"))
        delete = service_pb2.DeleteJobRequest(id=job.id)
        self.client.until_state(job.id, job_pb2.RUNNING)
        self.client.until_step(job.id, 1)
        self.refused(grpc.StatusCode.FAILED_PRECONDITION, self.client.stub.DeleteJob, delete,
                     timeout=10)
        self.client.cancel(job.id)
        self.refused(grpc.StatusCode.ABORTED, self.client.stub.DeleteJob, delete, timeout=10)
        self.client.until_state(job.id, job_pb2.CANCELLED)
        self.client.stub.DeleteJob(delete, timeout=10)


if __name__ == "__main__":
    main()
