"""Cases, runs and results of a dccast server.

>>> import dccast
>>> service = dccast.connect()
>>> job = service.submit("start-2d-thickness", quality="draft", time__end="20 s").wait()
>>> job.state
'SUCCEEDED'
>>> job.curl["corner_curl_m"].shape == job.curl["time_s"].shape
True

Units are read and checked by the server, as in a case file; figures that come back are SI and degrees
Celsius, with the unit in the name. docs/python.md is the guide.
"""
from dccast.cases import Case
from dccast.castings import Forecast, Preparation
from dccast.errors import DccastError, Fault, UnknownState
from dccast.frames import Frame, Frames
from dccast.jobs import Event, Job, Watch
from dccast.judgements import Comparison, Difference, Judgement
from dccast.logins import login
from dccast.plots import plot_chart, plot_curl
from dccast.runs import Answer, Band, Run
from dccast.service import Service, connect
from dccast.studies import Prediction, Study

__version__ = "1.0.0"

__all__ = [
    "Answer", "Band", "Case", "Comparison", "DccastError", "Difference", "Event", "Fault", "Forecast", "Frame",
    "Frames", "Job", "Judgement", "Prediction", "Preparation", "Run", "Service", "Study", "UnknownState",
    "Watch", "__version__", "connect", "login", "plot_chart", "plot_curl",
]
