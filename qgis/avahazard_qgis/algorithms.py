"""The algorithms: each calls one command of avahazard, and loads what it has written."""

from __future__ import annotations

from pathlib import Path

from processing.core.ProcessingConfig import ProcessingConfig
from qgis.core import (
    QgsProcessing,
    QgsProcessingAlgorithm,
    QgsProcessingContext,
    QgsProcessingException,
    QgsProcessingOutputNumber,
    QgsProcessingOutputString,
    QgsProcessingParameterBoolean,
    QgsProcessingParameterEnum,
    QgsProcessingParameterFile,
    QgsProcessingParameterFileDestination,
    QgsProcessingParameterRasterLayer,
    QgsProcessingParameterString,
    QgsProcessingParameterVectorLayer,
    QgsProcessingUtils,
    QgsProviderRegistry,
    QgsRasterLayer,
    QgsVectorFileWriter,
    QgsVectorLayer,
)

from . import command
from .settings import COMMAND

DATABASE, NAME, OUTPUT = "DATABASE", "NAME", "OUTPUT"
LIMITS, ENGINES = ["swiss", "french"], ["block", "com1dfa"]
LANGUAGES = ["en", "de", "fr", "it"]


class AvahazardAlgorithm(QgsProcessingAlgorithm):
    """What all have in common: the database, the run of the command, messages."""

    KEY, TITLE, HELP = "", "", ""

    def createInstance(self):  # noqa: N802
        """Return another of its kind."""
        return type(self)()

    def name(self):
        """Its name in commands."""
        return self.KEY

    def displayName(self):  # noqa: N802
        """Its name for people."""
        return self.TITLE

    def shortHelpString(self):  # noqa: N802
        """What it does."""
        return self.HELP

    def initAlgorithm(self, _configuration=None):  # noqa: N802
        """Declare the parameters, those of the database first."""
        self.addParameter(
            QgsProcessingParameterFile(DATABASE, "Database", extension="db")
            if self.KEY != "import"
            else QgsProcessingParameterFileDestination(
                DATABASE, "Database (made where it is not there)", "Database (*.db)"
            )
        )
        self.declare()

    def ask_name(self, words="Model"):
        """Declare the name of a model."""
        self.addParameter(QgsProcessingParameterString(NAME, words))

    def ask_file(self, words, kind):
        """Declare the file to be written."""
        self.addParameter(QgsProcessingParameterFileDestination(OUTPUT, words, kind))

    def text(self, parameters, name, context):
        """The text of a parameter."""
        return self.parameterAsString(parameters, name, context)

    def call(self, database, words, feedback):
        """Run a command and return its document; its failure is an error of the algorithm."""
        try:
            named = ProcessingConfig.getSetting(COMMAND) or ""
            whole = command.words_of(command.find_command(named), database, words)
            feedback.pushCommandInfo(" ".join(whole))

            def progress(what, share):
                feedback.setProgressText(what)
                feedback.setProgress(share)

            found = command.run(whole, feedback.pushInfo, progress, feedback.isCanceled)
        except command.CommandError as error:
            raise QgsProcessingException(str(error)) from error
        if feedback.isCanceled():
            raise QgsProcessingException("Cancelled; what was done before is kept.")
        return found


def load_geopackage(file, context):
    """Let QGIS load the layers of a GeoPackage, each with its own style."""
    sublayers = QgsProviderRegistry.instance().querySublayers(file)
    for one in sublayers:
        if one.name() == "layer_styles":
            continue
        layer = QgsVectorLayer(one.uri(), one.name(), "ogr")
        if layer.isValid():
            _load(layer, context)


def _load(layer, context):
    context.temporaryLayerStore().addMapLayer(layer)
    details = QgsProcessingContext.LayerDetails(layer.name(), context.project(), layer.name())
    context.addLayerToLoadOnCompletion(layer.id(), details)


class ImportRecords(AvahazardAlgorithm):
    """Import."""

    KEY, TITLE = "import", "Import records"
    HELP = (
        "Imports paths, profiles, events and speeds from a folder or a table, and lines on a "
        "terrain model. All or nothing is imported; bad rows are listed."
    )

    def declare(self):
        """Declare the parameters."""
        self.addParameter(
            QgsProcessingParameterFile(
                "FOLDER", "Folder with tables", QgsProcessingParameterFile.Folder, optional=True
            )
        )
        self.addParameter(QgsProcessingParameterFile("TABLE", "A single table", optional=True))
        self.addParameter(
            QgsProcessingParameterVectorLayer(
                "LINES", "Lines of paths", [QgsProcessing.TypeVectorLine], optional=True
            )
        )
        self.addParameter(QgsProcessingParameterRasterLayer("DEM", "Terrain model", optional=True))
        self.addParameter(
            QgsProcessingParameterBoolean("UPDATE", "Replace stored rows that differ", False)
        )
        self.addOutput(QgsProcessingOutputNumber("PATHS", "New paths"))
        self.addOutput(QgsProcessingOutputNumber("EVENTS", "New events"))

    def processAlgorithm(self, parameters, context, feedback):  # noqa: N802
        """Make the database if need be, and import."""
        database = self.parameterAsFileOutput(parameters, DATABASE, context)
        sources = [
            self.parameterAsString(parameters, name, context) for name in ("FOLDER", "TABLE")
        ]
        sources = [source for source in sources if source]
        lines = self.parameterAsVectorLayer(parameters, "LINES", context)
        if lines is not None:
            sources.append(_written(lines, context))
        if not sources:
            raise QgsProcessingException("There is nothing to import: name a folder, table, lines.")
        dem = self.parameterAsRasterLayer(parameters, "DEM", context)
        if command.is_new(database):
            self.call(database, ["init"], feedback)
        update = self.parameterAsBool(parameters, "UPDATE", context)
        file = "" if dem is None else dem.source()
        found = self.call(database, command.import_words(sources, file, update), feedback)
        new = {kind: counts["new"] for kind, counts in found["records"].items()}
        return {DATABASE: database, "PATHS": new["paths"], "EVENTS": new["events"]}


def _written(layer, context):
    """A layer as a file of its own: it may be filtered, edited or in memory."""
    file = str(Path(QgsProcessingUtils.tempFolder()) / f"{layer.name() or 'lines'}.gpkg")
    options = QgsVectorFileWriter.SaveVectorOptions()
    options.driverName = "GPKG"
    QgsVectorFileWriter.writeAsVectorFormatV3(layer, file, context.transformContext(), options)
    return file


class Calibrate(AvahazardAlgorithm):
    """Calibrate."""

    KEY, TITLE = "calibrate", "Calibrate a model"
    HELP = "Calibrates P[friction | volume] on the records and stores the model."

    def declare(self):
        """Declare the parameters."""
        self.ask_name("Name of the new model")
        self.addParameter(
            QgsProcessingParameterString("EFFECTS", "Effects, with commas", optional=True)
        )
        self.addParameter(
            QgsProcessingParameterEnum("FORWARD", "What runs", ENGINES, defaultValue=0)
        )
        self.addOutput(QgsProcessingOutputString("PARAMETERS", "Parameters"))

    def processAlgorithm(self, parameters, context, feedback):  # noqa: N802
        """Calibrate, and tell the parameters."""
        name = self.text(parameters, NAME, context)
        forward = ENGINES[self.parameterAsEnum(parameters, "FORWARD", context)]
        words = command.calibrate_words(name, self.text(parameters, "EFFECTS", context), forward)
        found = self.call(self.text(parameters, DATABASE, context), words, feedback)
        told = [
            f"{key} = {one['mean']:.4g} ± {one['sd']:.2g} {one['unit']}".rstrip()
            for key, one in found["parameters"].items()
        ]
        for line in told:
            feedback.pushInfo(line)
        return {"PARAMETERS": "; ".join(told)}


class Diagnose(AvahazardAlgorithm):
    """Diagnose."""

    KEY, TITLE = "diagnose", "Find what a model misses"
    HELP = "Compares a model with the records, and names the effect that is missing, if any."

    def declare(self):
        """Declare the parameters."""
        self.ask_name()
        self.addOutput(QgsProcessingOutputString("VERDICT", "Verdict"))
        self.addOutput(QgsProcessingOutputString("MISSING", "Missing"))

    def processAlgorithm(self, parameters, context, feedback):  # noqa: N802
        """Diagnose, and tell the verdict."""
        words = ["diagnose", self.text(parameters, NAME, context)]
        found = self.call(self.text(parameters, DATABASE, context), words, feedback)
        missing = ", ".join(found["missing"])
        feedback.pushInfo(f"{found['verdict']}: {missing or 'nothing'}")
        return {"VERDICT": found["verdict"], "MISSING": missing}


class Hazard(AvahazardAlgorithm):
    """Hazard."""

    KEY, TITLE = "hazard", "Design runouts"
    HELP = (
        "Computes the runouts that are exceeded once in the return periods, and writes them with "
        "paths and recorded stops as a GeoPackage with styles."
    )

    def declare(self):
        """Declare the parameters."""
        self.ask_name()
        self.addParameter(
            QgsProcessingParameterString("PERIODS", "Return periods (years)", "30, 100, 300")
        )
        self.ask_file("Layers", "GeoPackage (*.gpkg)")

    def processAlgorithm(self, parameters, context, feedback):  # noqa: N802
        """Compute, export and load."""
        database, name = (self.text(parameters, key, context) for key in (DATABASE, NAME))
        file = self.parameterAsFileOutput(parameters, OUTPUT, context)
        periods = self.text(parameters, "PERIODS", context)
        self.call(database, command.hazard_words(name, periods), feedback)
        self.call(database, ["export", name, "-o", file], feedback)
        load_geopackage(file, context)
        return {OUTPUT: file}


class Map(AvahazardAlgorithm):
    """Map."""

    KEY, TITLE = "map", "Map of annual chances"
    HELP = (
        "Draws the annual chance of an avalanche and of its pressures in the cells of the terrain "
        "(.tif), or the areas of return periods and zones (.gpkg), from the runs of `simulate`."
    )

    def declare(self):
        """Declare the parameters."""
        self.ask_name()
        self.addParameter(QgsProcessingParameterEnum("LIMITS", "Zones", LIMITS, defaultValue=0))
        self.ask_file("Map", "GeoTIFF (*.tif);;GeoPackage (*.gpkg)")

    def processAlgorithm(self, parameters, context, feedback):  # noqa: N802
        """Draw and load."""
        file = self.parameterAsFileOutput(parameters, OUTPUT, context)
        limits = LIMITS[self.parameterAsEnum(parameters, "LIMITS", context)]
        words = command.map_words(self.text(parameters, NAME, context), file, limits)
        self.call(self.text(parameters, DATABASE, context), words, feedback)
        if file.lower().endswith(".gpkg"):
            load_geopackage(file, context)
        else:
            _load(QgsRasterLayer(file, Path(file).stem), context)
        return {OUTPUT: file}


class Report(AvahazardAlgorithm):
    """Report."""

    KEY, TITLE = "report", "Report"
    HELP = "Writes the report of a model, brief and annex, as one file of HTML."

    def declare(self):
        """Declare the parameters."""
        self.ask_name()
        self.addParameter(
            QgsProcessingParameterEnum("LANGUAGE", "Language", LANGUAGES, defaultValue=0)
        )
        self.addParameter(QgsProcessingParameterString("TITLE", "Title", optional=True))
        self.ask_file("Report", "HTML (*.html)")

    def processAlgorithm(self, parameters, context, feedback):  # noqa: N802
        """Write it."""
        file = self.parameterAsFileOutput(parameters, OUTPUT, context)
        language = LANGUAGES[self.parameterAsEnum(parameters, "LANGUAGE", context)]
        name, title = (self.text(parameters, key, context) for key in (NAME, "TITLE"))
        words = command.report_words(name, file, language, title)
        self.call(self.text(parameters, DATABASE, context), words, feedback)
        return {OUTPUT: file}


ALGORITHMS = (ImportRecords, Calibrate, Diagnose, Hazard, Map, Report)
