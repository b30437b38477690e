"""Recognition of the shape that is held."""

from .model import ShapeModel as ShapeModel
from .model import grasp_features as grasp_features
from .model_file import load_shape_model as load_shape_model
from .model_file import save_shape_model as save_shape_model
from .recognizer import ShapeRecognizer as ShapeRecognizer
from .training import train_shape_model as train_shape_model
