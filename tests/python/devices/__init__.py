"""Files as devices write them, made from the formats' specifications: for tests, mutations and the table in docs/.

Every module has functions that return bytes or write a file. None of them uses the readers that it is meant to test.
"""
